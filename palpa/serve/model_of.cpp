#include "palpa/serve/model_of.h"

#include <algorithm>

namespace palpa {

namespace {

bool is_level(const PlacedPrimitive& placed) noexcept { return placed.captured.any(); }
bool is_facet(const PlacedPrimitive& placed) noexcept { return placed.primitive.kind == PrimitiveKind::corner; }

std::span<const PlacedPrimitive> last_rows(const Session& session) noexcept {
  if (session.sub_steps().empty()) return {};
  const SubStep& last = session.sub_steps().back();
  return session.primitives().subspan(last.first_primitive, last.primitives);
}

// The place of a row on its axis or plane that is nearest to the proxy: short ways are rounded least.
Vec3 nearest_offset_m(const Primitive& p, const Vec3& proxy_m) noexcept {
  const Vec3 offset_m = p.position_m - proxy_m;
  const double along_m = dot(p.direction, offset_m);
  switch (p.kind) {
    case PrimitiveKind::line: return offset_m - along_m * p.direction;
    case PrimitiveKind::plane:
    case PrimitiveKind::corner: return along_m * p.direction;
    case PrimitiveKind::directed: return {};
    case PrimitiveKind::point: return offset_m;
  }
  return offset_m;
}

ModelRow row_of(const PlacedPrimitive& placed, double time_step_s, const Vec3& proxy_m) noexcept {
  const Primitive& p = placed.primitive;
  const auto shortened = [](double value) { return static_cast<float>(value); };
  ModelRow row;
  row.kind = p.kind;
  row.rides = placed.rides;
  row.mode = p.id.mode;
  row.slot = p.id.slot;
  row.strength_n = shortened(p.strength_n);
  row.drag_ns_per_m = shortened(p.drag_ns_per_m);
  row.stiffness_n_per_m = shortened(p.stiffness_n_per_m);
  row.coefficient = shortened(placed.coefficient);
  row.offset_m = placed.rides ? Vec3{} : nearest_offset_m(p, proxy_m);
  row.direction = p.direction;
  if (time_step_s > 0.0 && placed.carried_m != Vec3{}) row.velocity_m_per_s = placed.carried_m / time_step_s;
  if (norm(row.velocity_m_per_s) > ModelRow::fastest_m_per_s) row.velocity_m_per_s = {};
  return row;
}

// Appends the rows of one primitive: `placed` from `at` on, with its further facets. Returns its rows; 0: no room.
std::size_t append(std::span<const PlacedPrimitive> placed, std::size_t at, double time_step_s, bool ahead,
                   ModelUpdate& model) noexcept {
  std::size_t count = 1;
  while (is_facet(placed[at]) && at + count < placed.size() && is_facet(placed[at + count]) &&
         placed[at + count].primitive.id == placed[at].primitive.id)
    ++count;
  if (model.count + count > ModelUpdate::most_rows) return 0;
  for (std::size_t n = 0; n < count; ++n) {
    ModelRow row = row_of(placed[at + n], time_step_s, model.proxy_m);
    row.ahead = ahead;
    row.is_facet = n > 0;
    if (placed[at].plane_slot >= 0) {
      const auto is_plane = [&](const ModelRow& of) {
        return of.mode == row.mode && of.slot == placed[at].plane_slot && !of.is_facet;
      };
      const auto plane = std::find_if(model.rows.begin(), model.rows.begin() + model.count, is_plane);
      if (plane == model.rows.begin() + model.count) return count;  // a line without its plane: no friction
      row.plane = static_cast<std::int32_t>(plane - model.rows.begin());
    }
    model.rows[model.count++] = row;
  }
  return count;
}

bool has(const ModelUpdate& model, const PrimitiveId& id) noexcept {
  return std::any_of(model.rows.begin(), model.rows.begin() + model.count,
                     [&](const ModelRow& row) { return row.mode == id.mode && row.slot == id.slot; });
}

}  // namespace

void take_rows(const Session& session, ModelUpdate& model) noexcept {
  const std::span<const PlacedPrimitive> placed = last_rows(session);
  if (session.sub_steps().empty()) return;
  const double time_step_s = session.sub_steps().back().time_step_s;
  model.count = 0;
  for (std::size_t at = 0; at < placed.size();) at += std::max<std::size_t>(1, append(placed, at, time_step_s, false, model));
}

int add_levels_ahead(const Session& session, ModelUpdate& model) noexcept {
  const std::span<const PlacedPrimitive> placed = last_rows(session);
  const double time_step_s = session.sub_steps().empty() ? 0.0 : session.sub_steps().back().time_step_s;
  int levels = 0;
  for (std::size_t at = 0; at < placed.size();) {
    const bool joins = is_level(placed[at]) && !has(model, placed[at].primitive.id);
    const bool rubs = levels > 0 && placed[at].plane_slot >= 0 && !has(model, placed[at].primitive.id);
    const std::size_t count = joins || rubs ? append(placed, at, time_step_s, true, model) : 1;
    levels += joins && count > 0;
    at += std::max<std::size_t>(1, count);
  }
  return levels;
}

}  // namespace palpa
