# Tests of this module, built into tests/tread_tests.
set(here ${CMAKE_CURRENT_LIST_DIR})
target_sources(tread_tests PRIVATE
  ${here}/physics_model_test.cpp
  ${here}/rover_body_test.cpp
  ${here}/tyre_test.cpp
  ${here}/walker_body_test.cpp
)
