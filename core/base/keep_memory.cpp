// SPDX-License-Identifier: Apache-2.0
#include "core/base/keep_memory.h"

#include <cstdlib>
#if defined(__GLIBC__)
#include <malloc.h>
#endif

namespace flare {

void KeepFreedMemory() {
#if defined(__GLIBC__)
    // From here on an allocation is a mapping of its own and goes back at once; the most that the
    // library takes. A plane of eight million pixels.
    constexpr int kAlone_bytes = 32 << 20;
    constexpr int kKept_bytes = 256 << 20;  // free at the end of a heap
    mallopt(M_MMAP_THRESHOLD, kAlone_bytes);
    mallopt(M_TRIM_THRESHOLD, kKept_bytes);
#endif
}

}  // namespace flare
