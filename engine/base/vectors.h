// Wide vectors where the processor has them: a function marked PLANTLOOP_WIDE is compiled for AVX2, to be called only
// when has_wide_vectors is true. Bits stay the same: an element-wise loop rounds alike at every width, and AVX2 brings
// no fused multiply-add.

#pragma once

namespace plantloop {

#if defined(__x86_64__)
#define PLANTLOOP_WIDE [[gnu::target("avx2")]]
inline const bool has_wide_vectors = __builtin_cpu_supports("avx2") != 0;
#else
#define PLANTLOOP_WIDE
inline constexpr bool has_wide_vectors = false;
#endif

}  // namespace plantloop
