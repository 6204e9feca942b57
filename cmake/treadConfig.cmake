# find_package(tread) then target_link_libraries(mine PRIVATE tread::tread)
list(APPEND CMAKE_MODULE_PATH ${CMAKE_CURRENT_LIST_DIR})
include(${CMAKE_CURRENT_LIST_DIR}/TreadDependencies.cmake)
include(${CMAKE_CURRENT_LIST_DIR}/treadTargets.cmake)
