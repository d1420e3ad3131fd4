#include "palpa/trace/windows.h"

#include "palpa/data/octave_parts.h"
#include "palpa/trace/columns.h"
#include "palpa/trace/rows.h"

namespace palpa {

std::vector<TracedField> traced_fields(const Scene& scene) {
  std::vector<TracedField> fields;
  for (const SceneVolume& volume : scene.volumes()) {
    for (const VolumeField& field : volume.volume.fields) {
      int frame = 0;
      for (const Octaves* octaves : frames_in_octaves(*field.field))
        fields.push_back({volume.name, field.name, field.field, octaves, frame++});
    }
  }
  return fields;
}

std::vector<TracedWindow> traced_windows(const std::filesystem::path& trace) {
  std::vector<TracedWindow> all;
  detail::each_row(trace / detail::windows_table().file, detail::windows_table().names(), [&](const detail::Row& row) {
    TracedWindow& one = all.emplace_back();
    one.tick = row.number<std::int64_t>(0);
    one.volume = row.text(1), one.field = row.text(2);
    one.place.octave = row.number<int>(3);
    for (std::size_t a = 0; a < 3; ++a) {
      one.place.first[a] = row.number<std::int64_t>(4 + a);
      one.place.dims[a] = row.number<std::int64_t>(7 + a);
    }
    one.frame = row.number<int>(10);
    return true;
  });
  return all;
}

std::vector<TracedChunks> traced_chunks(const std::filesystem::path& trace) {
  std::vector<TracedChunks> all;
  detail::each_row(trace / detail::chunks_table().file, detail::chunks_table().names(), [&](const detail::Row& row) {
    const std::string volume = row.text(5), field = row.text(6);
    const int frame = row.number<int>(7);
    if (all.empty() || all.back().volume != volume || all.back().field != field || all.back().frame != frame)
      all.push_back({volume, field, {}, frame});
    ChunkSum& sum = all.back().sums.emplace_back();
    sum.octave = row.number<int>(0);
    for (std::size_t a = 0; a < 3; ++a) sum.at[a] = row.number<std::int64_t>(1 + a);
    sum.crc32 = row.number<std::uint32_t>(4);
    return true;
  });
  return all;
}

}  // namespace palpa
