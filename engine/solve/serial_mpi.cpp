// The names of Open MPI that the archives of SUNDIALS 7 ask for, so that a serial program needs not load it.
//
// SUNDIALS calls them only for a communicator other than SUN_COMM_NULL, and plantloop has none. Built where
// cmake/sundials.cmake says so.

#include <cassert>

extern "C" {

// Objects whose address alone matters: MPI_COMM_NULL, MPI_DOUBLE, MPI_LONG.
char ompi_mpi_comm_null[1024];  // NOLINT
char ompi_mpi_double[1024];     // NOLINT
char ompi_mpi_long[1024];       // NOLINT

#define PLANTLOOP_NEVER_CALLED(name) \
  int name() {                       \
    assert(!"MPI in a serial run");  \
    return 1;                        \
  }

PLANTLOOP_NEVER_CALLED(MPI_Abort)
PLANTLOOP_NEVER_CALLED(MPI_Comm_dup)
PLANTLOOP_NEVER_CALLED(MPI_Comm_free)
PLANTLOOP_NEVER_CALLED(MPI_Comm_rank)
PLANTLOOP_NEVER_CALLED(MPI_Comm_size)
PLANTLOOP_NEVER_CALLED(MPI_Op_create)
PLANTLOOP_NEVER_CALLED(MPI_Op_free)
PLANTLOOP_NEVER_CALLED(MPI_Reduce)
PLANTLOOP_NEVER_CALLED(MPI_Type_commit)
PLANTLOOP_NEVER_CALLED(MPI_Type_create_resized)
PLANTLOOP_NEVER_CALLED(MPI_Type_create_struct)
PLANTLOOP_NEVER_CALLED(MPI_Type_free)
PLANTLOOP_NEVER_CALLED(MPI_Type_get_extent)

}  // extern "C"
