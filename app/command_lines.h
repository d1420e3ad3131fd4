// Command lines: the options of each command and its action.
#pragma once

#include <atomic>
#include <functional>

namespace CLI {
class App;
}

namespace palpa::app {

/// Action of a parsed command; returns the exit code.
using Work = std::function<int()>;

// Each adds its command to the program; if chosen, the command sets `work`. A signal sets `stop`.

void add_demo(CLI::App& app, Work& work, const std::atomic<bool>& stop);
void add_run(CLI::App& app, Work& work, int argc, char** argv, const std::atomic<bool>& stop);
void add_serve(CLI::App& app, Work& work, int argc, char** argv, const std::atomic<bool>& stop);
void add_devices(CLI::App& app, Work& work, const std::atomic<bool>& stop);
void add_explore(CLI::App& app, Work& work);

void add_info(CLI::App& app, Work& work);
void add_convert(CLI::App& app, Work& work, const std::atomic<bool>& stop);
void add_prepare(CLI::App& app, Work& work, const std::atomic<bool>& stop);

void add_replay(CLI::App& app, Work& work, const std::atomic<bool>& stop);
void add_report(CLI::App& app, Work& work);
void add_export(CLI::App& app, Work& work);

void add_check(CLI::App& app, Work& work, const std::atomic<bool>& stop);
void add_map(CLI::App& app, Work& work, const std::atomic<bool>& stop);
void add_modes(CLI::App& app, Work& work);

}  // namespace palpa::app
