#include "app/hand_words.h"

#include <span>

#include "palpa/device/hand.h"

namespace palpa::app {
namespace {

std::string table(std::span<const Described> rows) {
  std::string out;
  for (const Described& row : rows) {
    const std::string name = row.name;
    out += "  " + name + std::string(name.size() < 27 ? 27 - name.size() : 1, ' ') + row.sentence + "\n";
  }
  return out;
}

std::string devices() {
  std::string out;
  for (const DevicePlant& plant : device_presets())
    out += "  " + plant.name + std::string(27 - plant.name.size(), ' ') + format_plant(plant) + "\n";
  return out;
}

}  // namespace

std::string hand_words() {
  return "Simulated hands begin 20 mm in front of the first contact, as seen from the user, approach\n"
         "at up to 0.1 m/s until contact, and then perform the motion of their name:\n" +
         table(simulated_hands) +
         "with any of these keys, as in sim:stroke,depth_m=0.01,speed_m_per_s=0.2 (in brackets: if left out):\n" +
         table(simulated_hand_keys) +
         "Recorded hands are CSV files, with a header that decides the form; further columns are skipped:\n" +
         table(recorded_hands) +
         "All but ticks.csv have no position in the scene: they are moved to the position where the hand is longest\n"
         "in contact.\n"
         "A hand holds a device (--device), which adds to its mass and reads its place in steps:\n" +
         devices() + "with any of these keys, as in touch,encoder_step_m=2e-5,delay_ticks=2:\n" + table(device_keys) + "\n";
}

}  // namespace palpa::app
