# Tests of this module, built into tests/tread_tests.
set(here ${CMAKE_CURRENT_LIST_DIR})
target_sources(tread_tests PRIVATE
  ${here}/camera_shot_test.cpp
  ${here}/camera_view_test.cpp
  ${here}/ground_kernel_test.cpp
  ${here}/hash_noise_test.cpp
  ${here}/image_sensor_test.cpp
  ${here}/scene_test.cpp
  ${here}/texture_test.cpp)
