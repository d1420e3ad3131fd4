// The shared library consists of the layers; this file only gives it a source of its own.
#include "palpa/version.h"
