# For tests and benchmarks: palpa_problems, the families of problems, and palpa_balance_reference, the reference of 113 bits. On
# platforms without that floating point there is no target palpa_balance_reference, and its users are left out.
include_guard(GLOBAL)
include(CheckCXXSourceCompiles)

add_library(palpa_problems STATIC EXCLUDE_FROM_ALL ${CMAKE_CURRENT_LIST_DIR}/problem_families.cpp
  ${CMAKE_CURRENT_LIST_DIR}/pose_problems.cpp)
target_link_libraries(palpa_problems PRIVATE palpa_rules PUBLIC palpa_solver)

check_cxx_source_compiles("__float128 a = 1; int main() { return a * a > 2; }" PALPA_HAS_FLOAT128)
check_cxx_source_compiles("#include <cfloat>
  static_assert(LDBL_MANT_DIG == 113); int main() {}" PALPA_HAS_QUAD_LONG_DOUBLE)
if(NOT PALPA_HAS_FLOAT128 AND NOT PALPA_HAS_QUAD_LONG_DOUBLE)
  message(WARNING "no floating point of 113 bits (__float128 or long double) with this compiler: "
    "the tests and benchmarks of the solver against the reference are left out")
  return()
endif()
add_library(palpa_balance_reference STATIC EXCLUDE_FROM_ALL
  ${CMAKE_CURRENT_LIST_DIR}/reference.cpp ${CMAKE_CURRENT_LIST_DIR}/reference_bound.cpp
  ${CMAKE_CURRENT_LIST_DIR}/pose_reference.cpp)
target_link_libraries(palpa_balance_reference PRIVATE palpa_rules PUBLIC palpa_problems)
