# SPDX-License-Identifier: BSD-3-Clause
# Sanitizers for all targets of the package, as LIDAR_MAPPING_SANITIZE says.
if(LIDAR_MAPPING_SANITIZE STREQUAL "address")
  # A number beyond the range of the type that it is put into is no error of `undefined`.
  set(LIDAR_MAPPING_SANITIZERS address,undefined,float-cast-overflow)
  # Under this sanitizer Eigen takes an allocator of its own, and cannot free what libraries that are
  # not sanitized, such as PCL's, have allocated by malloc.
  add_compile_definitions(EIGEN_MALLOC_ALREADY_ALIGNED=1)
elseif(LIDAR_MAPPING_SANITIZE STREQUAL "thread")
  set(LIDAR_MAPPING_SANITIZERS thread)
elseif(LIDAR_MAPPING_SANITIZE)
  message(FATAL_ERROR "LIDAR_MAPPING_SANITIZE is ${LIDAR_MAPPING_SANITIZE}; "
                      "it has to be address, thread or OFF")
endif()
if(LIDAR_MAPPING_SANITIZE)
  add_compile_options(-fsanitize=${LIDAR_MAPPING_SANITIZERS} -fno-sanitize-recover=all
                      -fno-omit-frame-pointer)
  add_link_options(-fsanitize=${LIDAR_MAPPING_SANITIZERS})
endif()
