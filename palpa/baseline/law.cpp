#include "palpa/baseline/law.h"
