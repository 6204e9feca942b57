# Tests of this module, built into tests/tread_tests.
set(here ${CMAKE_CURRENT_LIST_DIR})
target_sources(tread_tests PRIVATE
  ${here}/body_sensors_test.cpp
  ${here}/camera_shot_test.cpp
  ${here}/camera_view_test.cpp
  ${here}/carried_body_test.cpp
  ${here}/course_test.cpp
  ${here}/fault_test.cpp
  ${here}/gnss_sensor_test.cpp
  ${here}/ground_kernel_test.cpp
  ${here}/hash_noise_test.cpp
  ${here}/image_sensor_test.cpp
  ${here}/imu_sensor_test.cpp
  ${here}/pan_tilt_test.cpp
  ${here}/physics_model_test.cpp
  ${here}/random_test.cpp
  ${here}/relief_test.cpp
  ${here}/rover_body_test.cpp
  ${here}/route_driver_test.cpp
  ${here}/scene_test.cpp
  ${here}/sensor_channel_test.cpp
  ${here}/simulated_robot_test.cpp
  ${here}/texture_test.cpp
  ${here}/tyre_test.cpp
  ${here}/walker_body_test.cpp
  ${here}/world_test.cpp
)
