# Tests of this module, built into tests/tread_tests.
set(here ${CMAKE_CURRENT_LIST_DIR})
target_sources(tread_tests PRIVATE
  ${here}/atomic_file_test.cpp
  ${here}/data_set_writer_errors_test.cpp
  ${here}/data_set_writer_test.cpp
  ${here}/image_file_test.cpp
  ${here}/image_header_test.cpp
  ${here}/imu_file_test.cpp
  ${here}/map_files_test.cpp
  ${here}/map_yaml_test.cpp
  ${here}/mesh_file_test.cpp
  ${here}/nav2_map_test.cpp
  ${here}/options_file_test.cpp
  ${here}/pfm_file_test.cpp
  ${here}/raster_file_errors_test.cpp
  ${here}/raster_file_test.cpp
  ${here}/recording_files_test.cpp
  ${here}/recording_folder_test.cpp
  ${here}/rgbd_camera_test.cpp
  ${here}/rgbd_lists_test.cpp
  ${here}/rgbd_source_test.cpp
  ${here}/rig_file_damaged_test.cpp
  ${here}/rig_file_test.cpp
  ${here}/rig_format_pairs_test.cpp
  ${here}/rig_formats_test.cpp
  ${here}/source_euroc_test.cpp
  ${here}/source_size_test.cpp
  ${here}/source_test.cpp
  ${here}/stereo_folder_test.cpp
  ${here}/text_test.cpp
  ${here}/text_tree_test.cpp
  ${here}/trajectory_file_test.cpp
)
