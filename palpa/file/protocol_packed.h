// Which files come with memory for what they hold, because gzip has packed them as a whole.
#pragma once

#include <string>

namespace palpa::protocol {

/// Whether a file is packed, by its first bytes; false where it cannot be opened. Any thread. Throws LoadError where the disk
/// fails.
bool is_packed(const std::string& path);

}  // namespace palpa::protocol
