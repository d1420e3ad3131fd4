#include "palpa/field/derived.h"
