# cmake -DOUT=FILE.cpp -DFILES=A;B -P embed.cmake: files as C++ constants, for resources.h.
set(entries)
set(texts)
set(number 0)
foreach(file IN LISTS FILES)
  file(READ "${file}" text)
  file(SHA256 "${file}" sha256)
  cmake_path(GET file FILENAME name)
  if(text MATCHES "\\)palpa_text\"" OR text MATCHES "\r" OR text MATCHES "</[sS][cC][rR][iI][pP][tT]")
    message(FATAL_ERROR "${file}: cannot stand in a page as it is; it holds ')palpa_text\"', a carriage return or the end of a script")
  endif()
  string(APPEND texts "constexpr char text_${number}[] = R\"palpa_text(${text})palpa_text\";\n")
  string(APPEND entries "    {\"${name}\", {text_${number}, sizeof text_${number} - 1}, \"${sha256}\"},\n")
  math(EXPR number "${number} + 1")
endforeach()
file(WRITE "${OUT}" "#include \"palpa/report/resources.h\"

#include <algorithm>
#include <cassert>
#include <iterator>

namespace palpa::detail {
namespace {
${texts}
constexpr Resource all[] = {
${entries}};
}  // namespace

const Resource& resource(std::string_view name) {
  const auto* const found = std::find_if(std::begin(all), std::end(all), [&](const Resource& one) { return one.name == name; });
  assert(found != std::end(all));
  return *found;
}

}  // namespace palpa::detail
")
