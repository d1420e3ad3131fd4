// Hints about memory: this machine takes none.
#pragma once
#include <stddef.h>

#define MADV_HUGEPAGE 14
inline int madvise(void*, size_t, int) { return 0; }
