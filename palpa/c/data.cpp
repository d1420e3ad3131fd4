// Functions for C of the data's side.
#include <chrono>

#include "palpa/c.h"
#include "palpa/c/failure.h"
#include "palpa/c/message_arguments.h"
#include "palpa/c/scene_handle.h"
#include "palpa/serve/data_side.h"

struct palpa_data {
  palpa::DataSide side;
  std::chrono::steady_clock::time_point began = std::chrono::steady_clock::now();

  double now_s() const noexcept { return std::chrono::duration<double>(std::chrono::steady_clock::now() - began).count(); }
};

using namespace palpa::c;

extern "C" {

palpa_data* palpa_data_new(const palpa_scene* scene) {
  return pointer_of("palpa_data_new", [&] {
    return std::make_unique<palpa_data>(palpa::DataSide(given(scene, "scene").recipe.scene())).release();
  });
}

void palpa_data_free(palpa_data* data) { delete data; }

palpa_result palpa_data_take(palpa_data* data, const void* message, size_t bytes) {
  constexpr const char* place = "palpa_data_take";
  if (!data) return fail(PALPA_WRONG_ARGUMENT, place, "data is NULL; give one");
  if (!message) return fail(PALPA_WRONG_ARGUMENT, place, "message is NULL; give one");
  bool is_taken = false;
  const palpa_result result =
      result_of(place, [&] { is_taken = data->side.take(message_given(message, bytes), data->now_s()); });
  if (result != PALPA_OK || is_taken) return result;
  return fail(PALPA_WRONG_DATA, place, "the message is none of a hand, an old one, or before a hello; it is passed over");
}

size_t palpa_data_give(palpa_data* data, void* message, size_t room) {
  constexpr const char* place = "palpa_data_give";
  if (const char* problem = problem_with_room(data, "data is NULL; give one", message, room))
    return fail(0, place, problem), std::size_t{0};
  std::size_t bytes = 0;
  result_of(place, [&] { bytes = data->side.give(room_given(message, room), data->now_s()); });
  return bytes;
}

palpa_result palpa_data_change(palpa_data* data, const palpa_scene* scene) {
  return result_of("palpa_data_change", [&] {
    if (!data) throw WrongArgument("data is NULL; give one");
    data->side.change(given(scene, "scene").recipe.scene());
  });
}
}
