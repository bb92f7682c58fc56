// What the doors to SUNDIALS share: its objects as owners, and a context that never prints. It knows versions 6 and 7.
// Only the doors include this file.

#pragma once

#include <nvector/nvector_serial.h>
#include <sundials/sundials_context.h>
#include <sundials/sundials_logger.h>
#include <sundials/sundials_types.h>
#include <sunlinsol/sunlinsol_dense.h>
#include <sunlinsol/sunlinsol_klu.h>
#include <sunmatrix/sunmatrix_dense.h>
#include <sunmatrix/sunmatrix_sparse.h>

#include <memory>
#include <new>
#include <type_traits>

namespace plantloop {

constexpr int widest_dense = 64;  // above this many unknowns a sparse Jacobian pays

// SUNDIALS' objects are freed in reverse order of their making, the context last.
struct FreeContext {
  void operator()(SUNContext context) const { SUNContext_Free(&context); }
};
struct FreeVector {
  void operator()(N_Vector vector) const { N_VDestroy(vector); }
};
struct FreeMatrix {
  void operator()(SUNMatrix matrix) const { SUNMatDestroy(matrix); }
};
struct FreeLinear {
  void operator()(SUNLinearSolver solver) const { SUNLinSolFree(solver); }
};
template <typename Pointer, typename Free>
using Owned = std::unique_ptr<std::remove_pointer_t<Pointer>, Free>;

#if SUNDIALS_VERSION_MAJOR >= 7
inline void ignore_error(int, const char*, const char*, const char*, SUNErrCode, void*, SUNContext) {}
#else
inline void ignore_error(int, const char*, const char*, char*, void*) {}
#endif

// A context that never prints.
inline Owned<SUNContext, FreeContext> make_context() {
  SUNContext context = nullptr;
#if SUNDIALS_VERSION_MAJOR >= 7
  if (SUNContext_Create(SUN_COMM_NULL, &context) != 0) throw std::bad_alloc();
  SUNContext_ClearErrHandlers(context);
  SUNContext_PushErrHandler(context, ignore_error, nullptr);
  SUNLogger logger = nullptr;
  if (SUNContext_GetLogger(context, &logger) == 0 && logger) SUNLogger_SetWarningFilename(logger, "/dev/null");
#else
  if (SUNContext_Create(nullptr, &context) != 0) throw std::bad_alloc();
#endif
  return Owned<SUNContext, FreeContext>(context);
}

}  // namespace plantloop
