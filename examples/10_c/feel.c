/* A grid of the program's own in a scene, felt by a hand that presses: all that a program in C needs. */
#include <palpa/c.h>
#include <stdio.h>

enum { n = 32 };
static float warmth[n * n * n];

static const char* toml =
    "palpa = 1\n"
    "coupling = {stiffness_n_per_m = 400, max_force_n = 3}\n"
    "volume.room = {}                      # its voxels come from this program\n"
    "[[mode]]\n"
    "name = \"floor\"\n"
    "type = \"surface_and_friction\"\n"
    "field = \"room\"\n"
    "level = [{name = \"warm\", value = 20, strength_n = 2}]\n";

int main(void) {
  palpa_grid grid = {.size = sizeof grid, .type = PALPA_FLOAT32, .components = 1, .dims = {n, n, n}, .slope = 1};
  for (int i = 0; i < n * n * n; ++i) warmth[i] = 20 + 10 - 20.0f * (i / (n * n)) / (n - 1); /* 30 below, 10 above */
  for (int i = 0; i < 3; ++i) grid.axes_m[i][i] = 0.1 / (n - 1), grid.origin_m[i] = -0.05;   /* 0.1 m wide */
  grid.voxels = warmth, grid.bytes = sizeof warmth;

  palpa_scene* scene = palpa_scene_parse(toml, NULL);
  palpa_result result = scene ? palpa_scene_add_grid(scene, "room", &grid) : PALPA_WRONG_DATA;
  palpa_session* session = result == PALPA_OK ? palpa_session_new(scene, 0) : NULL;
  palpa_scene_free(scene);
  if (!session) return fprintf(stderr, "feel: %s\n", palpa_last_error()), 2;

  palpa_tick tick = {.size = sizeof tick};
  for (int i = 0; i < 40 && result == PALPA_OK; ++i) { /* 1 ms a tick */
    palpa_probe hand = {.size = sizeof hand, .valid = 1, .position_m = {0, 0, 0.002 - 1e-4 * i}, .turn = {1, 0, 0, 0}};
    result = palpa_session_tick(session, &hand, 1e-3, &tick);
  }
  palpa_session_free(session);
  printf("force %.3f N, proxy at %.3f mm\n", tick.force_n[2], 1e3 * tick.proxy_m[2]);
  return result == PALPA_OK && tick.force_n[2] > 0.7 && tick.force_n[2] < 0.8 ? 0 : 1; /* 400 N/m over 1.9 mm */
}
