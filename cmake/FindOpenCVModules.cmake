# opencv::core, opencv::imgproc, ... from the packages of the single modules (libopencv-core-dev and
# so on). OpenCV's own CMake file comes only with libopencv-dev, which brings everything.
find_path(OpenCVModules_INCLUDE_DIR opencv2/core.hpp PATH_SUFFIXES opencv4)
include(FindPackageHandleStandardArgs)
set(_opencv_found ${OpenCVModules_INCLUDE_DIR})
foreach(module core imgproc imgcodecs calib3d)
  find_library(OpenCVModules_${module}_LIBRARY opencv_${module})
  list(APPEND _opencv_required OpenCVModules_${module}_LIBRARY)
endforeach()
find_package_handle_standard_args(OpenCVModules
  REQUIRED_VARS OpenCVModules_INCLUDE_DIR ${_opencv_required})
if(OpenCVModules_FOUND)
  foreach(module core imgproc imgcodecs calib3d)
    if(NOT TARGET opencv::${module})
      add_library(opencv::${module} UNKNOWN IMPORTED)
      # SYSTEM: its headers warn under C++20.
      set_target_properties(opencv::${module} PROPERTIES
        IMPORTED_LOCATION ${OpenCVModules_${module}_LIBRARY}
        INTERFACE_INCLUDE_DIRECTORIES ${OpenCVModules_INCLUDE_DIR}
        INTERFACE_SYSTEM_INCLUDE_DIRECTORIES ${OpenCVModules_INCLUDE_DIR})
    endif()
    mark_as_advanced(OpenCVModules_${module}_LIBRARY)
  endforeach()
endif()
mark_as_advanced(OpenCVModules_INCLUDE_DIR)
