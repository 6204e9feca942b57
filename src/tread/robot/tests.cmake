# Tests of this module, built into tests/tread_tests.
set(here ${CMAKE_CURRENT_LIST_DIR})
target_sources(tread_tests PRIVATE
  ${here}/rover_model_test.cpp
  ${here}/walker_model_test.cpp
)
