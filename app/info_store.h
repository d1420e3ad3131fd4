// Facts of an OME-Zarr store as `palpa info` prints them, from its metadata and a sample of its chunks.
#pragma once

#include <optional>
#include <string>

#include "app/info_facts.h"
#include "app/info_table.h"
#include "palpa/file/octave_places.h"
#include "palpa/file/store_survey.h"
#include "palpa/study/expected_octaves.h"

namespace palpa::app {

struct StoreFacts {
  std::string name;  ///< as it was asked for
  StoreContents contents;
  OctavePlaces places;
  StoreSurvey survey;
  double most_bytes = 0.0;                      ///< of octave 0 of a store that is in memory as a whole
  std::optional<OctaveExpectation> expected{};  ///< of a larger one that can be felt, as a first scene has it

  double whole_bytes() const noexcept;  ///< of octave 0 in memory: one frame of all fields
  /// Too large to be read as a whole for its facts.
  bool is_large() const noexcept { return whole_bytes() > most_bytes; }
};

/// Facts of a store; none of other files, of series, and of a store that is read only as a whole. At most a second, of one that
/// is felt through windows three, of a prepared one a minute. Throws LoadError of a large store that cannot be read.
std::optional<StoreFacts> store_facts_of(const Asked& asked, const ReadOptions& read);

/// Options to read a store as a whole for its facts: no large one. Of other files `read`.
ReadOptions options_for_whole(const Asked& asked, ReadOptions read);

/// All that is printed of a large store.
InfoTable store_table(const StoreFacts& facts);
/// Adds the store's facts to those of octave 0.
void add_store(InfoTable& table, const StoreFacts& facts);

}  // namespace palpa::app
