# plantloop::sundials: CVODE and IDA with serial vectors, dense and sparse matrices and KLU, for both releases that Debian has.
#
# Linked as archives: SUNDIALS 7 of Debian 13 drags in Open MPI, whose libraries take 50 ms to load in every process. The
# archives need only the names of some functions that a serial run never calls; engine/solve/serial_mpi.cpp has them.
# Note that sunindextype has 64 bits in Debian 12's SUNDIALS 6.4 and 32 in Debian 13's 7.1.
include_guard()
find_package(SUNDIALS REQUIRED CONFIG)

add_library(plantloop_sundials INTERFACE)
add_library(plantloop::sundials ALIAS plantloop_sundials)
foreach(part cvode ida sunnonlinsolnewton sunnonlinsolfixedpoint sunlinsoldense sunlinsolklu sunmatrixdense sunmatrixsparse nvecserial core
        generic)
  if(TARGET SUNDIALS::${part}_static)
    target_link_libraries(plantloop_sundials INTERFACE $<TARGET_FILE:SUNDIALS::${part}_static>)
  endif()
endforeach()
target_link_libraries(plantloop_sundials INTERFACE SUNDIALS::KLU m)

if(TARGET SUNDIALS::core_static)  # SUNDIALS 7
  add_library(plantloop_serial_mpi STATIC ${CMAKE_SOURCE_DIR}/engine/solve/serial_mpi.cpp)
  target_link_libraries(plantloop_serial_mpi PRIVATE plantloop_options)
  target_link_libraries(plantloop_sundials INTERFACE plantloop_serial_mpi)
  find_path(PLANTLOOP_MPI_INCLUDE mpi.h HINTS ${MPI_CXX_INCLUDE_DIRS} REQUIRED)  # sundials_types.h reads it
  target_include_directories(plantloop_sundials SYSTEM INTERFACE ${PLANTLOOP_MPI_INCLUDE})
endif()
