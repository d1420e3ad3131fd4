/* A hand that is far from its data: both sides in one process, messages in memory. A program of one's own sends them on a
 * network. cc -std=c99 far.c $(pkg-config --cflags --libs palpa) -lm */
#define _POSIX_C_SOURCE 199309L
#include <math.h>
#include <palpa/c.h>
#include <stdio.h>
#include <time.h>

static const char* toml =
    "palpa = 1\n"
    "coupling = {stiffness_n_per_m = 400}\n"
    "volume.head = {analytic = \"head_phantom\"}\n"
    "[[mode]]\n"
    "name = \"skin\"\n"
    "type = \"surface_and_friction\"\n"
    "field = \"head\"\n"
    "level = [{name = \"skin\", value = -300, strength_n = 0.8, friction_n = 0.1}]\n";

int main(void) {
  static unsigned char message[PALPA_MESSAGE_BYTES];
  const palpa_limits limits = {.size = sizeof limits,
                               .max_force_n = 3,
                               .max_stiffness_n_per_m = 800,
                               .max_damping_ns_per_m = 2,
                               .continuous_force_n = 1};
  palpa_scene* scene = palpa_scene_parse(toml, NULL);
  palpa_data* data = scene ? palpa_data_new(scene) : NULL;  /* where the data are */
  palpa_hand* hand = data ? palpa_hand_new(&limits) : NULL; /* where the device is */
  if (!hand) return fprintf(stderr, "%s\n", palpa_last_error()), 1;
  palpa_command command = {.size = sizeof command};
  const struct timespec tick = {.tv_nsec = 1000000};
  for (int n = 0; n < 60; ++n) { /* a hand presses, 1 ms a tick */
    nanosleep(&tick, NULL);
    palpa_probe at = {.size = sizeof at, .valid = 1, .position_m = {0, 0.02, 0.052 - 1e-4 * n}};
    palpa_hand_tick(hand, &at, 1e-3, &command);
    /* to the motors: command.force_n */
    size_t bytes;
    while ((bytes = palpa_hand_give(hand, message, sizeof message)) > 0) palpa_data_take(data, message, bytes);
    while ((bytes = palpa_data_give(data, message, sizeof message)) > 0) palpa_hand_take(hand, message, bytes);
  }
  const double* f = command.force_n;
  const double force_n = sqrt(f[0] * f[0] + f[1] * f[1] + f[2] * f[2]);
  printf("force %.2f N, model %.0f ms old\n", force_n, 1e3 * command.model_age_s);
  palpa_hand_free(hand);
  palpa_data_free(data);
  palpa_scene_free(scene);
  return force_n > 0.1 ? 0 : 1;
}
