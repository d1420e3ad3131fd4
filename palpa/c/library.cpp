// Functions for C of the library itself.
#include <cstdlib>

#include "palpa/c.h"
#include "palpa/c/failure.h"
#include "palpa/version.h"

extern "C" {

uint32_t palpa_abi(void) { return PALPA_ABI; }
const char* palpa_version(void) { return palpa::version; }
const char* palpa_last_error(void) { return palpa::c::last_sentence(); }
void palpa_free(void* text) { std::free(text); }
}
