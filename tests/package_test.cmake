# Installs the build to a scratch folder, builds tests/package against it and runs that.
# -D BUILD=... SOURCE=... COMPILER=... FLAGS=...
file(REMOVE_RECURSE ${BUILD}/package_test)
function(run)
  execute_process(COMMAND ${ARGN} RESULT_VARIABLE status OUTPUT_VARIABLE output ERROR_VARIABLE output)
  if(NOT status EQUAL 0)
    message(FATAL_ERROR "${ARGN}\n${output}")
  endif()
  set(output "${output}" PARENT_SCOPE)
endfunction()
run(${CMAKE_COMMAND} --install ${BUILD} --prefix ${BUILD}/package_test/prefix)
run(${CMAKE_COMMAND} -G Ninja -S ${SOURCE}/tests/package -B ${BUILD}/package_test/build
    -DCMAKE_PREFIX_PATH=${BUILD}/package_test/prefix -DCMAKE_CXX_COMPILER=${COMPILER}
    -DCMAKE_CXX_FLAGS=${FLAGS})
# Nothing may be asked of a user that the library does not link, and no header of a test be installed.
file(STRINGS ${BUILD}/package_test/build/CMakeCache.txt unneeded
     REGEX "^OpenCVModules_calib3d_LIBRARY")
if(unneeded)
  message(FATAL_ERROR "the package looks for what it does not use: ${unneeded}")
endif()
file(GLOB_RECURSE test_headers ${BUILD}/package_test/prefix/include/*test*.hpp)
if(test_headers)
  message(FATAL_ERROR "headers of tests are installed: ${test_headers}")
endif()
run(${CMAKE_COMMAND} --build ${BUILD}/package_test/build)
run(${BUILD}/package_test/build/user)
if(NOT output MATCHES "waypoints: 2")
  message(FATAL_ERROR "the program printed: ${output}")
endif()
run(${BUILD}/package_test/prefix/bin/tread --version)
