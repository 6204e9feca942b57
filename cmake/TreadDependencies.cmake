# Every library that tread stands on, and no other: used by the build and by the installed package
# alike. What only programs and benchmarks need, they look for themselves.
include(CMakeFindDependencyMacro)
find_dependency(Eigen3 3.4)
find_dependency(tl-expected)
find_dependency(fmt)
find_dependency(TBB)
find_dependency(hwy)
find_dependency(yaml-cpp)
find_dependency(JPEG)
find_dependency(PNG)
find_dependency(TIFF)
find_dependency(GeoTIFF)
find_dependency(Ceres)
find_dependency(embree 3)
find_dependency(MuJoCo)
find_dependency(OpenCVModules COMPONENTS core features2d imgcodecs imgproc video)

# yaml-cpp 0.7 exports a target without a name space and, on Debian, without its include folder.
if(TARGET yaml-cpp AND NOT TARGET yaml-cpp::yaml-cpp)
  add_library(yaml-cpp::yaml-cpp ALIAS yaml-cpp)
endif()
