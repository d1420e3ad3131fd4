// All campaigns, in the order of the table; parts that are not built add none.
#pragma once

#include "tests/fuzz/campaign.h"

namespace palpa::fuzz {

void add_ticks(std::vector<Campaign>& to);
void add_guard(std::vector<Campaign>& to);
void add_c_calls(std::vector<Campaign>& to);
void add_messages(std::vector<Campaign>& to);
void add_texts(std::vector<Campaign>& to);
void add_files(std::vector<Campaign>& to);
void add_protocol(std::vector<Campaign>& to);
void add_faults(std::vector<Campaign>& to);

inline std::vector<Campaign> all_campaigns() {
  std::vector<Campaign> all;
  add_ticks(all);
  add_guard(all);
  add_c_calls(all);
  add_messages(all);
  add_texts(all);
#if PALPA_HAS_READER
  add_files(all);
#endif
  add_protocol(all);
  add_faults(all);
  return all;
}

}  // namespace palpa::fuzz
