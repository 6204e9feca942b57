# Tests of this module, built into tests/tread_tests.
set(here ${CMAKE_CURRENT_LIST_DIR})
target_sources(tread_tests PRIVATE
  ${here}/a_star_test.cpp ${here}/bucket_queue_test.cpp
  ${here}/line_cost_test.cpp ${here}/planner_test.cpp)
