# Tests of this module, built into tests/tread_tests.
set(here ${CMAKE_CURRENT_LIST_DIR})
target_sources(tread_tests PRIVATE
  ${here}/grid_test.cpp ${here}/image_test.cpp ${here}/options_test.cpp ${here}/parallel_test.cpp
  ${here}/problems_test.cpp ${here}/raw_image_test.cpp ${here}/result_test.cpp)
