/* An Inverse3 in C99, whose Inverse Service is this program, in memory: from the first connection to the last message. Fails at
 * the first thing that is not so. */
#include <math.h>
#include <palpa/c.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#define CHECK(condition)                                                                               \
  do {                                                                                                 \
    if (!(condition)) {                                                                                \
      fprintf(stderr, "%s:%d: not so: %s (%s)\n", __FILE__, __LINE__, #condition, palpa_last_error()); \
      exit(1);                                                                                         \
    }                                                                                                  \
  } while (0)

static palpa_inverse3* inverse3;
static double now_s = 100;
static int is_open, is_asked, connections, closings, is_done;
static int answers = 1, has_power = 1;
static double force_n[3]; /* received, in the service's axes: x to the right, y away from the user, z up */
static char given[PALPA_MESSAGE_BYTES];
static size_t given_bytes;

/* ---- the service ---- */

static const char* state(void) {
  static char text[600];
  sprintf(text,
          "{\"inverse3\":[{\"device_id\":\"049D\",\"state\":{\"cursor_position\":{\"x\":0.01,\"y\":0.02,\"z\":0.03},"
          "\"cursor_velocity\":{\"x\":0,\"y\":0,\"z\":0.5}},\"status\":{\"power_supply\":%s}}],"
          "\"verse_grip\":[{\"device_id\":\"7\",\"state\":{\"button\":true}}]}",
          has_power ? "true" : "false");
  return text;
}

static void obey(void) {
  char* at;
  given[given_bytes] = '\0';
  at = strstr(given, "\"vector\":{\"x\":");
  if (!at) at = strstr(given, "\"values\":{\"x\":");
  if (!at) { /* a question alone */
    CHECK(strstr(given, "force_render_full_state"));
    memset(force_n, 0, sizeof force_n);
    return;
  }
  force_n[0] = strtod(at + 14, &at);
  force_n[1] = strtod(at + 5, &at);
  force_n[2] = strtod(at + 5, &at);
}

/* ---- the program ---- */

static void follow(void) {
  int act;
  while ((act = palpa_inverse3_look(inverse3, now_s)) != PALPA_INVERSE3_NOTHING) {
    CHECK(act > 0 && !(is_done && act != PALPA_INVERSE3_DONE));
    if (act == PALPA_INVERSE3_CONNECT) {
      CHECK(!is_open);
      is_open = 1;
      is_asked = 0;
      ++connections;
      CHECK(!answers || palpa_inverse3_take(inverse3, state(), strlen(state()), now_s) == PALPA_OK);
    }
    if (act == PALPA_INVERSE3_CLOSE) {
      is_open = 0;
      ++closings;
      CHECK(palpa_inverse3_take(inverse3, NULL, 0, now_s) == PALPA_OK);
    }
    if (act == PALPA_INVERSE3_DONE) {
      is_done = 1;
      return;
    }
  }
  given_bytes = palpa_inverse3_give(inverse3, given, sizeof given, now_s);
  if (given_bytes > 0) {
    CHECK(is_open && given_bytes < sizeof given);
    obey();
    is_asked = 1;
  }
}

static void tick(double x_n, double y_n, double z_n) {
  double wanted_n[3];
  wanted_n[0] = x_n, wanted_n[1] = y_n, wanted_n[2] = z_n;
  now_s += 1e-3;
  if (is_open && is_asked && answers) {
    is_asked = 0;
    CHECK(palpa_inverse3_take(inverse3, state(), strlen(state()), now_s) == PALPA_OK);
  }
  CHECK(palpa_inverse3_write(inverse3, wanted_n, now_s) == PALPA_OK);
  follow();
}

static const char* fault_at(double time_s) {
  palpa_probe probe;
  const char* fault = "none yet";
  probe.size = sizeof probe;
  CHECK(palpa_inverse3_read(inverse3, &probe, &fault, time_s) == PALPA_OK);
  CHECK(fault || probe.valid);
  return fault;
}

static void begin(const palpa_inverse3_options* options) {
  is_open = is_done = connections = closings = 0;
  answers = has_power = 1;
  inverse3 = palpa_inverse3_new(options);
  CHECK(inverse3);
}

static void feel(void) {
  palpa_probe probe;
  int n;
  begin(NULL);
  CHECK(strstr(fault_at(now_s), "not there"));
  follow();
  CHECK(strstr(given, "\"palpa:palpa\""));
  for (n = 0; n < 9; ++n) {
    tick(0.5, 1, -1.5);
    CHECK(force_n[0] == 0 && force_n[1] == 0 && force_n[2] == 0 && fault_at(now_s));
  }
  tick(0.5, 1, -1.5);
  CHECK(force_n[0] == 0.5 && force_n[1] == 1.5 && force_n[2] == 1 && connections == 1);
  CHECK(!strstr(given, "palpa:palpa"));
  probe.size = sizeof probe;
  CHECK(palpa_inverse3_read(inverse3, &probe, NULL, now_s) == PALPA_OK);
  CHECK(probe.valid && probe.has_velocity && probe.buttons == 1 && probe.turn[0] == 1 && probe.size == sizeof probe);
  CHECK(probe.position_m[0] == 0.01 && probe.position_m[1] == 0.03 && probe.position_m[2] == -0.02);
  CHECK(probe.velocity_m_per_s[1] == 0.5);
  tick(3000, 4000, 0);
  tick(3000, 4000, 0);
  CHECK(fabs(hypot(force_n[0], force_n[2]) - 3) < 1e-12 && !fault_at(now_s));
  tick(NAN, 0, 0);
  CHECK(force_n[0] == 0);
}

static void lose_and_find(void) {
  int n;
  /* A pause of the program. */
  tick(1, 0, 0);
  CHECK(force_n[0] == 1);
  now_s += 10;
  CHECK(strstr(fault_at(now_s), "does not answer"));
  tick(1, 0, 0);
  CHECK(force_n[0] == 0);
  for (n = 0; n < 20; ++n) tick(1, 0, 0);
  CHECK(force_n[0] == 1 && connections == 1);
  /* No power. */
  has_power = 0;
  tick(1, 0, 0);
  tick(1, 0, 0);
  CHECK(force_n[0] == 0 && strstr(fault_at(now_s), "power supply"));
  has_power = 1;
  for (n = 0; n < 20; ++n) tick(1, 0, 0);
  CHECK(force_n[0] == 1);
  /* Messages that were not asked for. */
  for (n = 0; n < 5; ++n) palpa_inverse3_take(inverse3, state(), strlen(state()), now_s);
  CHECK(strstr(palpa_last_error(), "palpa_inverse3_take: "));
  follow();
  CHECK(closings == 1 && !is_open);
  for (n = 0; n < 400; ++n) tick(1, 0, 0);
  CHECK(connections == 2 && force_n[0] == 1 && !fault_at(now_s));
  /* No answers, then a service again. */
  answers = 0;
  for (n = 0; n < 2000; ++n) tick(1, 0, 0);
  CHECK(closings >= 2 && fault_at(now_s));
  answers = 1;
  for (n = 0; n < 2000; ++n) tick(1, 0, 0);
  CHECK(force_n[0] == 1 && !fault_at(now_s));
}

static void end(void) {
  int n;
  CHECK(palpa_inverse3_end(inverse3, now_s) == PALPA_OK);
  CHECK(is_asked);
  follow();
  CHECK(given_bytes > 0 && force_n[0] == 0);
  for (n = 0; n < 100 && !is_done; ++n) tick(1, 0, 0);
  CHECK(is_done && !is_open && force_n[0] == 0 && fault_at(now_s));
  CHECK(palpa_inverse3_look(inverse3, now_s + 1e4) == PALPA_INVERSE3_DONE);
  CHECK(palpa_inverse3_give(inverse3, given, sizeof given, now_s + 1e4) == 0);
  palpa_inverse3_free(inverse3);
  palpa_inverse3_free(NULL);
}

static void choose(void) {
  palpa_inverse3_options options;
  palpa_limits limits;
  int n;
  memset(&options, 0, sizeof options);
  CHECK(!palpa_inverse3_new(&options) && strstr(palpa_last_error(), "set it to sizeof(palpa_inverse3_options)"));
  options.size = sizeof options;
  options.device_id = "\"},{";
  CHECK(!palpa_inverse3_new(&options) && strstr(palpa_last_error(), "device_id cannot be; give 1 to 64 letters"));
  options.device_id = "049D";
  options.force_key = 3;
  CHECK(!palpa_inverse3_new(&options) && strstr(palpa_last_error(), "PALPA_FORCE_VALUES"));
  options.force_key = PALPA_FORCE_BY_VERSION;
  options.version = "{\"ok\":true,\"data\":{\"project_version\":\"3.4.2\"}}";
  options.profile = "org.example:lab";
  begin(&options);
  for (n = 0; n < 2; ++n) tick(1, 0, 0);
  CHECK(strstr(given, "\"049D\"") && strstr(given, "\"values\""));
  CHECK(palpa_inverse3_look(inverse3, NAN) == PALPA_WRONG_ARGUMENT);
  CHECK(palpa_inverse3_look(inverse3, now_s - 1) == PALPA_WRONG_ARGUMENT && strstr(palpa_last_error(), "steady clock"));
  palpa_inverse3_free(inverse3);
  options.version = "[]";
  options.device_id = "0BEE";
  begin(&options);
  for (n = 0; n < 300; ++n) tick(1, 0, 0);
  CHECK(strstr(fault_at(now_s), "not connected"));
  palpa_inverse3_free(inverse3);
  memset(&limits, 0, sizeof limits);
  CHECK(palpa_inverse3_limits(&limits) == PALPA_WRONG_ARGUMENT);
  limits.size = sizeof limits;
  CHECK(palpa_inverse3_limits(&limits) == PALPA_OK && limits.has_motors && limits.max_force_n == 3);
  CHECK(limits.max_stiffness_n_per_m == 800 && isinf(limits.max_damping_ns_per_m) && isinf(limits.continuous_force_n));
}

int main(void) {
  feel();
  lose_and_find();
  end();
  choose();
  puts("a device was felt");
  return 0;
}
