// Failures of the functions for C: the thread's sentence, and results in place of exceptions.
#pragma once

#include <new>
#include <span>
#include <stdexcept>
#include <string>
#include <string_view>

#include "palpa/base/load_error.h"
#include "palpa/c.h"

namespace palpa::c {

/// Makes `PLACE: TEXT` the thread's sentence, shortened if long; returns `kind`. Allocates nothing beyond the thread's first
/// sentence; any thread.
palpa_result fail(palpa_result kind, std::string_view place, std::string_view text) noexcept;
/// Likewise of a sentence with its place.
palpa_result fail(palpa_result kind, std::string_view sentence) noexcept;
/// Copies whole letters of a UTF-8 text, as many as fit with a zero behind them. Allocates nothing; any thread.
void copy_utf8(std::string_view text, std::span<char> to) noexcept;
/// The thread's sentence. Allocates nothing; any thread.
const char* last_sentence() noexcept;

/// An argument that cannot be used: half a sentence, `what; what would be right`.
class WrongArgument : public std::invalid_argument {
 public:
  using std::invalid_argument::invalid_argument;
};

/// Throws WrongArgument for a null pointer. \param name  of the argument
template <class T>
const T& given(const T* pointer, std::string_view name) {
  if (!pointer) throw WrongArgument(std::string(name) + " is NULL; give one");
  return *pointer;
}

/// Result of `act`; its exceptions become failures. Any thread.
/// \param place  name of the function
template <class Act>
palpa_result result_of(std::string_view place, Act act) noexcept {
  try {
    act();
    return PALPA_OK;
  } catch (const LoadError& error) {
    return fail(PALPA_WRONG_DATA, error.what());
  } catch (const WrongArgument& error) {
    return fail(PALPA_WRONG_ARGUMENT, place, error.what());
  } catch (const std::invalid_argument& error) {
    return fail(PALPA_WRONG_DATA, place, error.what());
  } catch (const std::bad_alloc&) {
    return fail(PALPA_NO_MEMORY, place, "not enough memory; use smaller data");
  } catch (const std::exception& error) {
    return fail(PALPA_FAULT, place, std::string_view(error.what()));
  } catch (...) {
    return fail(PALPA_FAULT, place, "unknown fault; report it with the scene");
  }
}

/// Pointer that `make` returns; nullptr after an exception. Any thread.
template <class Make>
auto pointer_of(std::string_view place, Make make) noexcept -> decltype(make()) {
  decltype(make()) made = nullptr;
  result_of(place, [&] { made = make(); });
  return made;
}

}  // namespace palpa::c
