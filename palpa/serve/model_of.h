// Model of a session's last sub-step, for the hand's side.
#pragma once

#include "palpa/far/message.h"
#include "palpa/session/session.h"

namespace palpa {

/// Replaces the rows of `model` by the primitives of the session's last sub-step, relative to `model.proxy_m`. A tick without a
/// sub-step leaves them as they are: nothing has moved. Rows beyond `ModelUpdate::most_rows` are left out. Allocates nothing.
void take_rows(const Session& session, ModelUpdate& model) noexcept;

/// Appends to `model` the levels among the session's last primitives that are not among its rows yet, as rows ahead, with their
/// friction. Returns the number of levels. Allocates nothing.
int add_levels_ahead(const Session& session, ModelUpdate& model) noexcept;

}  // namespace palpa
