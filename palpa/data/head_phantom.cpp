// Head phantom: a CT from signed distances.
#include "palpa/data/phantom_parts.h"

namespace palpa {

using namespace detail::phantom;

namespace {

constexpr double air_hu = -1000.0, tissue_hu = 40.0, bone_hu = 1000.0, brain_hu = 35.0;

// Millimetres; x to the left, y to the back, z to the top. Of pairs (ear, eye, sinus, …) only one side is given; the head is
// symmetric.
constexpr Ellipsoid cranium({0, 8, 45}, {76, 92, 73});
constexpr Ellipsoid cranium_bone({0, 8, 45}, {70, 86, 67});
constexpr Ellipsoid brain({0, 8, 45}, {63, 79, 60});
constexpr Ellipsoid face({0, -22, -35}, {60, 66, 82});
constexpr Ellipsoid face_bone({0, -22, -35}, {53, 59, 75});
constexpr Ellipsoid face_inside({0, -22, -35}, {45, 51, 67});
constexpr Capsule neck({0, 22, -200}, {0, 22, -50}, 52);
constexpr Capsule nose({0, -78, 0}, {0, -96, -30}, 9);
constexpr Ellipsoid ear({72, 14, 20}, {7, 14, 23});
constexpr Capsule eye_socket({32, -78, -3}, {26, -62, -3}, 15);
constexpr Capsule spine({0, 42, -200}, {0, 42, -30}, 15);
constexpr RoundBox nasal_wall({0, -54, -24}, {12, 21, 13}, 5.5);  // one for both sides: no seam on the septum
constexpr RoundBox nasal_cavity({8, -54, -24}, {4, 21, 13}, 2.5);
constexpr Ellipsoid sinus({31, -53, -38}, {11, 14, 14});
constexpr Capsule nostril({6, -94, -42}, {7, -76, -28}, 3);
constexpr Capsule throat({0, -28, -30}, {0, 12, -70}, 7);
constexpr Capsule windpipe({0, 12, -70}, {0, 12, -200}, 7);
constexpr double face_bone_back_m = -5e-3;  // behind it the jaw is open

/// Painted in layers, later over earlier: tissue, bone, cavities, brain; air outside of the skin.
ScalarSample head(const Vec3& world) noexcept {
  const Vec3 x{std::abs(world.x), world.y, world.z};
  const Distance brain_at = brain(x);
  if (brain_at.d <= -0.5 * edge_m) return {brain_hu, {}, true};

  const Distance skin_of_face = joined(joined(cranium(x), face(x), 25e-3), neck(x), 20e-3);
  const Weight skin = weight_of(joined(joined(skin_of_face, nose(x), 8e-3), ear(x), 10e-3));
  if (skin.w == 0.0) return {air_hu, {}, true};

  ScalarSample inner{tissue_hu, {}, true};
  const Distance skull = cranium_bone(x);
  const Distance jaw = shared(face_bone(x), {x.y - face_bone_back_m, {0, 1, 0}}, 10e-3);
  paint(inner, bone_hu, joined(skull, jaw, 25e-3));
  paint(inner, tissue_hu, shared(face_inside(x), negated(skull), 5e-3));
  paint(inner, tissue_hu, eye_socket(x));
  paint(inner, bone_hu, spine(x));
  const Distance sinus_at = sinus(x);
  paint(inner, bone_hu, nasal_wall(x));
  paint(inner, bone_hu, grown(sinus_at, 3e-3));
  paint(inner, air_hu, nasal_cavity(x));
  paint(inner, air_hu, sinus_at);
  paint(inner, air_hu, nostril(x));
  paint(inner, air_hu, throat(x));
  paint(inner, air_hu, windpipe(x));
  paint(inner, brain_hu, brain_at);

  ScalarSample s{air_hu + skin.w * (inner.value - air_hu), (inner.value - air_hu) * skin.g + skin.w * inner.gradient, true};
  s.gradient.x = world.x < 0.0 ? -s.gradient.x : s.gradient.x;
  return s;
}

}  // namespace

Volume head_phantom() {
  constexpr Box box{{-0.090, -0.115, -0.125}, {0.090, 0.110, 0.130}};
  Volume volume = volume_of("ct", "HU", box, 0.5 * edge_m, {{air_hu, bone_hu}}, [](const Vec3& x) noexcept { return head(x); });
  volume.medical_frame = true;
  return volume;
}

}  // namespace palpa
