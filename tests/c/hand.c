/* A hand in C99 by libpalpa-hand alone, whose data's side is this program: a welcome and a model of a floor, written byte by
 * byte as docs/far.md says. Fails at the first thing that is not so. */
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

static unsigned char message[PALPA_MESSAGE_BYTES];
static size_t length;

/* The numbers of a message are little endian; so is every machine that this runs on. */
static void put(const void* number, size_t bytes) {
  memcpy(message + length, number, bytes);
  length += bytes;
}
static void u8(int x) {
  unsigned char n = (unsigned char)x;
  put(&n, 1);
}
static void u16(unsigned x) {
  uint16_t n = (uint16_t)x;
  put(&n, 2);
}
static void u32(uint32_t x) { put(&x, 4); }
static void u64(uint64_t x) { put(&x, 8); }
static void f32(float x) { put(&x, 4); }
static void f64(double x) { put(&x, 8); }

static void begin(int kind) {
  length = 0;
  u16(1), u8(kind), u8(0), u32(0), u64(0);
}
static const void* end(void) {
  uint32_t bytes = (uint32_t)length;
  memcpy(message + 4, &bytes, 4);
  return message;
}

static void take_welcome(palpa_hand* hand) {
  begin(2);
  u32(1), f64(400), f64(0), f64(3), f64(0), u16(0);
  CHECK(palpa_hand_take(hand, end(), length) == PALPA_OK);
}

/* A floor at y = 0 that holds 2 N, with the proxy on it, or at a probe above. */
static void take_floor(palpa_hand* hand, uint64_t answers, uint64_t echo_us, double probe_y_m) {
  double y_m = probe_y_m > 0 ? probe_y_m : 0;
  int n;
  begin(4);
  u64(answers), u32(1), u64(echo_us), f32(0), f32(0), f32(0.01f);
  f64(0), f64(y_m), f64(0), u16(1);
  u8(2), u8(0), u16(0), u16(0), u8(0), u8(0);
  f32(2), f32(0), f32(INFINITY), f32(0);
  f32(0), f32((float)-y_m), f32(0); /* its place less the proxy */
  f32(0), f32(1), f32(0);
  for (n = 0; n < 3; ++n) f32(0);
  CHECK(palpa_hand_take(hand, end(), length) == PALPA_OK);
}

int main(void) {
  unsigned char room[PALPA_MESSAGE_BYTES];
  palpa_limits limits;
  palpa_probe probe;
  palpa_command command;
  palpa_hand* hand;
  int n, hellos = 0, reports = 0;
  uint64_t time_us;

  memset(&limits, 0, sizeof limits);
  CHECK(!palpa_hand_new(&limits) && strstr(palpa_last_error(), "set it to sizeof(palpa_limits)"));
  limits.size = sizeof limits;
  limits.max_force_n = 3.3;
  limits.max_stiffness_n_per_m = limits.max_damping_ns_per_m = limits.continuous_force_n = INFINITY;
  hand = palpa_hand_new(&limits);
  CHECK(hand);
  memset(&probe, 0, sizeof probe);
  probe.size = sizeof probe;
  probe.valid = 1;
  command.size = sizeof command;
  for (n = 1; n <= 200; ++n) {
    size_t bytes;
    probe.position_m[1] = 0.002 - 2e-5 * n; /* down to 2 mm below the floor */
    CHECK(palpa_hand_tick(hand, &probe, 1e-3, &command) == PALPA_OK);
    while ((bytes = palpa_hand_give(hand, room, sizeof room)) > 0) {
      CHECK(bytes > 16 && bytes <= PALPA_MESSAGE_BYTES);
      hellos += room[2] == 1;
      reports += room[2] == 3;
      memcpy(&time_us, room + 8, 8);
      if (room[2] == 1) take_welcome(hand);
      if (room[2] == 3) take_floor(hand, (uint64_t)n, time_us, probe.position_m[1]);
    }
  }
  CHECK(hellos == 1 && reports > 150);
  CHECK(command.link == PALPA_LINK_UP && command.guard == PALPA_GUARD_PASS);
  CHECK(fabs(command.force_n[1] - 0.8) < 0.02 && fabs(command.proxy_m[1]) < 1e-6);

  palpa_hand_panic(hand, 1);
  for (n = 0; n < 100; ++n) CHECK(palpa_hand_tick(hand, &probe, 1e-3, &command) == PALPA_OK);
  palpa_hand_panic(hand, 0);
  CHECK(palpa_hand_take(hand, room, 7) == PALPA_WRONG_DATA);
  CHECK(palpa_hand_take(hand, NULL, 0) == PALPA_OK); /* closed */
  CHECK(palpa_hand_tick(hand, &probe, 1e-3, &command) == PALPA_OK && command.link == PALPA_LINK_CLOSED);
  for (n = 0; n < 100; ++n) CHECK(palpa_hand_tick(hand, &probe, 1e-3, &command) == PALPA_OK);
  CHECK(command.force_n[1] == 0 && command.link == PALPA_LINK_WAITING);
  CHECK(palpa_hand_give(hand, room, sizeof room) > 0 && room[2] == 1); /* a hello again */
  palpa_hand_free(hand);
  palpa_hand_free(NULL);
  puts("a floor was felt");
  return 0;
}
