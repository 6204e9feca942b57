# Tests of this module, built into tests/tread_tests.
set(here ${CMAKE_CURRENT_LIST_DIR})
target_sources(tread_tests PRIVATE
  ${here}/cost_map_test.cpp
  ${here}/features_test.cpp
  ${here}/global_map_test.cpp
  ${here}/local_map_test.cpp
)
