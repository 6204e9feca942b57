# Tests of this module, built into tests/tread_tests.
set(here ${CMAKE_CURRENT_LIST_DIR})
target_sources(tread_tests PRIVATE
  ${here}/disparity_range_test.cpp
  ${here}/edge_image_test.cpp
  ${here}/filters_test.cpp
  ${here}/kernels_test.cpp
  ${here}/sad_matcher_test.cpp
  ${here}/stereo_matcher_test.cpp
  ${here}/temporal_filter_test.cpp
  ${here}/uncertainty_test.cpp)
