/* A mouse as a hand, with the guard, recorded: loop FOLDER; then palpa replay FOLDER. */
#include <palpa/c.h>
#include <stdio.h>

static const char* toml =
    "palpa = 1\n"
    "coupling = {stiffness_n_per_m = 400, max_force_n = 3}\n"
    "volume.head = {analytic = \"head_phantom\"}\n"
    "workspace = {scale = 1.5, towards_user = \"anterior\", up = \"superior\"}\n"
    "[[mode]]\n"
    "name = \"skin\"\n"
    "type = \"surface_and_friction\"\n"
    "field = \"head\"\n"
    "level = [{name = \"skin\", value = -300, strength_n = 2}]\n";

int main(int argc, char** argv) {
  palpa_scene* scene = palpa_scene_parse(toml, NULL);
  if (argc != 2) return fprintf(stderr, "usage: loop FOLDER\n"), 2;
  if (!scene) return fprintf(stderr, "%s\n", palpa_last_error()), 1;
  palpa_limits limits = {.size = sizeof limits};
  palpa_steered* mouse = palpa_steered_new(PALPA_MOUSE, &limits);
  palpa_loop* loop = mouse ? palpa_loop_new(scene, &limits) : NULL;
  if (!loop || palpa_loop_record(loop, argv[1], 1e-3, "mouse")) return fprintf(stderr, "%s\n", palpa_last_error()), 1;
  palpa_command command = {.size = sizeof command};
  for (int i = 0; i < 400; ++i) { /* the mouse goes down, 1 ms a tick */
    palpa_steering input = {.size = sizeof input, .way_m = {0, 0, -1e-4}};
    if (i == 0) input.is_put = 1, input.put_m[2] = 0.1;
    palpa_probe hand = {.size = sizeof hand};
    palpa_steered_read(mouse, &input, 1e-3, &hand);
    palpa_loop_tick(loop, &hand, 1e-3, 0, &command, NULL);
    palpa_steered_write(mouse, command.force_n);
  }
  printf("%.2f N\n", command.force_n[2]);
  if (palpa_loop_record(loop, NULL, 0, NULL)) return fprintf(stderr, "%s\n", palpa_last_error()), 1;
  palpa_loop_free(loop);
  palpa_steered_free(mouse);
  palpa_scene_free(scene);
  return 0;
}
