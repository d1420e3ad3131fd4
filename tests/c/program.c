/* A program in C99: a scene of a grid, felt, changed, copied, saved and felt again. Fails at the first thing that is not so. */
#define _POSIX_C_SOURCE 199309L
#include <math.h>
#include <palpa/c.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>

#define CHECK(condition)                                                                               \
  do {                                                                                                 \
    if (!(condition)) {                                                                                \
      fprintf(stderr, "%s:%d: not so: %s (%s)\n", __FILE__, __LINE__, #condition, palpa_last_error()); \
      exit(1);                                                                                         \
    }                                                                                                  \
  } while (0)

enum { n = 16, ticks = 400 };

static const char* toml =
    "palpa = 1\n[coupling]\nstiffness_n_per_m = 500\n[volume.ct]\n[[mode]]\nname = \"skin\"\n"
    "type = \"surface_and_friction\"\nfield = \"ct\"\n[[mode.level]]\nname = \"half\"\nvalue = 50\nstrength_n = 2\n";

static int16_t voxels[n * n * n];

static palpa_grid grid(void) {
  palpa_grid g;
  int i;
  memset(&g, 0, sizeof g);
  g.size = sizeof g;
  g.type = PALPA_INT16;
  g.components = 1;
  for (i = 0; i < 3; ++i) {
    g.dims[i] = n;
    g.origin_m[i] = -0.075;
    g.axes_m[i][i] = 0.01;
  }
  for (i = 0; i < n * n * n; ++i) voxels[i] = (int16_t)(10 * (n - 1 - i / (n * n))); /* falls along z: solid below */
  g.voxels = voxels;
  g.bytes = sizeof voxels;
  g.slope = 1.0;
  return g;
}

/* Presses along -z; returns the largest force. */
static double press(palpa_session* session, size_t* events) {
  double most_n = 0.0;
  int i;
  for (i = 0; i < ticks; ++i) {
    palpa_probe probe;
    palpa_tick tick;
    palpa_event event[4];
    memset(&probe, 0, sizeof probe);
    probe.size = sizeof probe;
    probe.valid = 1;
    probe.turn[0] = 1.0;
    probe.position_m[2] = 0.05 - 1e-4 * i;
    tick.size = sizeof tick;
    CHECK(palpa_session_tick(session, &probe, 1e-3, &tick) == PALPA_OK);
    CHECK(tick.status == PALPA_COMPLETE && tick.error_bound_m <= 1e-9);
    if (tick.force_n[2] > most_n) most_n = tick.force_n[2];
    event[0].size = sizeof event[0];
    *events += palpa_session_events(session, event, 4);
  }
  return most_n;
}

/* Blocks for a millisecond; returns the time since the last call in seconds. */
static double next_tick_s(void) {
  static struct timespec last;
  const struct timespec tick = {0, 1000000};
  struct timespec now;
  double passed_s;
  nanosleep(&tick, NULL);
  clock_gettime(CLOCK_MONOTONIC, &now);
  passed_s = last.tv_sec ? (double)(now.tv_sec - last.tv_sec) + 1e-9 * (double)(now.tv_nsec - last.tv_nsec) : 1e-3;
  last = now;
  return passed_s < 0.02 ? passed_s : 0.02;
}

/* Passes all messages between both sides. */
static void pass_messages(palpa_hand* hand, palpa_data* data) {
  unsigned char message[PALPA_MESSAGE_BYTES];
  size_t bytes;
  while ((bytes = palpa_hand_give(hand, message, sizeof message)) > 0) palpa_data_take(data, message, bytes);
  while ((bytes = palpa_data_give(data, message, sizeof message)) > 0) palpa_hand_take(hand, message, bytes);
}

/* Presses as above, with the data on another side; returns the largest force. */
static double press_far(const palpa_scene* scene, size_t* events) {
  palpa_limits limits;
  palpa_hand* hand;
  palpa_data* data;
  double most_n = 0.0;
  int i;
  memset(&limits, 0, sizeof limits);
  limits.size = sizeof limits;
  limits.max_force_n = 3.3;
  limits.max_stiffness_n_per_m = limits.max_damping_ns_per_m = limits.continuous_force_n = 1e9;
  hand = palpa_hand_new(&limits);
  data = palpa_data_new(scene);
  CHECK(hand && data);
  for (i = 0; i < ticks; ++i) {
    palpa_probe probe;
    palpa_command command;
    palpa_event event[4];
    memset(&probe, 0, sizeof probe);
    probe.size = sizeof probe;
    probe.valid = 1;
    probe.position_m[2] = 0.05 - 1e-4 * i;
    command.size = sizeof command;
    CHECK(palpa_hand_tick(hand, &probe, next_tick_s(), &command) == PALPA_OK);
    if (command.force_n[2] > most_n) most_n = command.force_n[2];
    pass_messages(hand, data);
    event[0].size = sizeof event[0];
    *events += palpa_hand_events(hand, event, 4);
  }
  CHECK(palpa_data_change(data, scene) == PALPA_OK && palpa_data_change(data, NULL) == PALPA_WRONG_ARGUMENT);
  CHECK(palpa_data_take(data, "no message", 10) == PALPA_WRONG_DATA);
  palpa_hand_free(hand);
  palpa_data_free(data);
  return most_n;
}

int main(void) {
  palpa_scene *scene, *copy, *again;
  palpa_session *session, *other;
  palpa_grid ct = grid();
  char *text, *warnings;
  size_t events = 0;
  double first_n, soft_n, far_n;

  CHECK(palpa_abi() >= PALPA_ABI && strlen(palpa_version()) > 0 && palpa_last_error()[0] == '\0');
  scene = palpa_scene_parse(toml, NULL);
  CHECK(scene);
  CHECK(!palpa_session_new(scene, 0.0) && strstr(palpa_last_error(), "volume 'ct' has no data yet; "));
  CHECK(palpa_scene_add_grid(scene, "ct", &ct) == PALPA_OK);
  memset(voxels, 0, sizeof voxels); /* they were copied */
  warnings = palpa_scene_warnings(scene);
  CHECK(warnings && warnings[0] == '\0');
  palpa_free(warnings);

  session = palpa_session_new(scene, 0.0);
  CHECK(session);
  first_n = press(session, &events);
  CHECK(fabs(first_n - 2.0) < 1e-6); /* the level's strength, then it broke */
  CHECK(events >= 2);

  events = 0;
  far_n = press_far(scene, &events);
  CHECK(fabs(far_n - 2.0) < 0.3 && events >= 2); /* models come a tick later, or more on a busy machine */

  copy = palpa_scene_copy(scene);
  CHECK(copy && palpa_scene_set(copy, "mode.skin.level.half.strength_n", "0.5") == PALPA_OK);
  palpa_scene_free(scene);
  text = palpa_scene_text(copy);
  CHECK(text && strstr(text, "strength_n = 0.5"));
  again = palpa_scene_parse(text, "/");
  palpa_free(text);
  ct = grid();
  CHECK(again && palpa_scene_add_grid(again, "ct", &ct) == PALPA_OK);
  other = palpa_session_new(again, 0.0);
  palpa_scene_free(again);
  palpa_scene_free(copy);
  CHECK(other && palpa_session_take_over(other, session) == PALPA_OK);
  palpa_session_reset(other);
  soft_n = press(other, &events);
  CHECK(fabs(soft_n - 0.5) < 1e-6);
  CHECK(palpa_session_tick(NULL, NULL, 1e-3, NULL) == PALPA_WRONG_ARGUMENT);

  palpa_session_free(session);
  palpa_session_free(other);
  palpa_session_free(NULL);
  palpa_scene_free(NULL);
  palpa_data_free(NULL);
  palpa_free(NULL);
  printf("felt %.3f N, far %.3f N, then %.3f N\n", first_n, far_n, soft_n);
  return 0;
}
