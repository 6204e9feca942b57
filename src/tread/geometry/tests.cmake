# Tests of this module, built into tests/tread_tests.
set(here ${CMAKE_CURRENT_LIST_DIR})
target_sources(tread_tests PRIVATE
  ${here}/camera_test.cpp
  ${here}/pose_test.cpp
  ${here}/positive_polynomial_test.cpp
  ${here}/rectification_test.cpp
  ${here}/stereo_rig_test.cpp
  ${here}/trajectory_error_test.cpp
  ${here}/trajectory_test.cpp)
