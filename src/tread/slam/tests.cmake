# Tests of this module, built into tests/tread_tests.
set(here ${CMAKE_CURRENT_LIST_DIR})
target_sources(tread_tests PRIVATE
  ${here}/align_kernel_test.cpp
  ${here}/align_test.cpp
  ${here}/compare_views_test.cpp
  ${here}/corner_tracker_test.cpp
  ${here}/depth_level_test.cpp
  ${here}/depth_slam_test.cpp
  ${here}/extract_mesh_test.cpp
  ${here}/fit_motion_test.cpp
  ${here}/frame_path_test.cpp
  ${here}/imu_preintegration_test.cpp
  ${here}/integrate_test.cpp
  ${here}/keyframe_bank_test.cpp
  ${here}/keyframe_store_test.cpp
  ${here}/loop_closer_test.cpp
  ${here}/observability_test.cpp
  ${here}/place_memory_test.cpp
  ${here}/pose_graph_test.cpp
  ${here}/ray_cast_test.cpp
  ${here}/refine_window_test.cpp
  ${here}/visual_odometry_test.cpp
  ${here}/voxel_volume_test.cpp
  ${PROJECT_SOURCE_DIR}/bench/rendered_scene.cpp)
