// Command lines of hands far from their data.
#include <CLI/CLI.hpp>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "app/command_lines.h"
#include "app/commands.h"
#include "app/options.h"
#include "palpa/base/load_error.h"

namespace palpa::app {

void add_data_at(CLI::App* command, FarArguments& far, const std::string& needed) {
  command->add_option("--data-at", far.data_at, needed)->type_name("HOST:PORT");
  command->add_option("--token", far.token, "with --data-at: the token that palpa serve printed (PALPA_TOKEN, or asked for)")
      ->type_name("TOKEN");
  command->add_flag("--tls", far.tls, "with --data-at: over TLS");
  command
      ->add_option("--ca", far.authority,
                   "with --data-at: over TLS, with a certificate of this authority (PEM; those of the system)")
      ->type_name("FILE");
  command->add_flag("--unencrypted", far.unencrypted, "with --data-at: also to another machine without TLS");
}

void check_data_at(const FarArguments& far, const std::string& command) {
  if (!far.data_at.empty()) return;
  const std::pair<bool, const char*> needing[] = {{!far.token.empty(), "--token"},  {far.tls, "--tls"},
                                                  {!far.authority.empty(), "--ca"}, {far.unencrypted, "--unencrypted"},
                                                  {!far.link.empty(), "--link"},    {far.datagrams, "--datagrams"},
                                                  {far.far_anyway, "--far-anyway"}};
  for (const auto& [is_given, option] : needing)
    if (is_given) throw LoadError(command + ": " + option + " is for data on another machine; add --data-at HOST:PORT");
}

namespace {

struct ServeLine {
  ServeArguments serve;
  std::vector<std::string> sets, tls;
  int igtl_port = -1;  // none
};

}  // namespace

void add_serve(CLI::App& app, Work& work, int argc, char** argv, const std::atomic<bool>& stop) {
  const auto given = std::make_shared<ServeLine>();
  RunOptions& options = given->serve.options;
  CLI::App* command = app.add_subcommand("serve", "Let hands and viewers on other machines feel and see a scene");
  command->add_option("SCENE", options.scene, "scene file (TOML)")->required()->type_name("");
  command->add_option("--port", given->serve.port, "0: one that is free (4711)")->type_name("N");
  command->add_option("--listen", given->serve.listen, "address of this machine (127.0.0.1, for this machine alone)")
      ->type_name("ADDRESS");
  command->add_option("--token-file", given->serve.token_file, "keep the tokens in this file, which only you can read")
      ->type_name("FILE");
  command->add_option("--tls", given->tls, "over TLS, with this certificate and its key (PEM)")
      ->expected(2)
      ->type_name("CERT KEY");
  command->add_flag("--unencrypted", given->serve.unencrypted, "with --listen: without TLS, although others can read along");
  command->add_flag("--datagrams", given->serve.datagrams,
                    "probes and models also by UDP, unencrypted, at the same port: steadier where packets are lost");
  command
      ->add_option(
          "--igtl", given->igtl_port,
          "show probes, proxies and events to 3D Slicer and other clients of OpenIGTLink on this machine, at this port; "
          "18944 is usual, 0 is any that is free")
      ->check(CLI::Range(0, 65535))
      ->type_name("PORT");
  command->add_option("--out", options.out, "record a trace of each hand in this new folder")->type_name("DIR");
  command->add_flag("--primitives", options.primitives, "record balances and primitives as well");
  add_repeated(command, "--data", options.scene_options.data_folders, "also search this folder for data")->type_name("DIR");
  add_repeated(command, "--set", given->sets, "change one value of the scene, as in mode.skin.friction_n=0.2")
      ->type_name("PATH=VALUE");
  add_plugins(command, options.plugins);
  add_reader(command, options.read);
  command->footer("Example:\n  palpa serve scenes/head_phantom.toml");
  command->callback([=, &work, &stop] {
    work = [=, &stop] {
      ServeArguments serve = given->serve;
      serve.options.arguments.assign(argv + 1, argv + argc);
      serve.options.scene_options.sets = split_sets(given->sets);
      if (given->igtl_port >= 0) serve.igtl_port = static_cast<std::uint16_t>(given->igtl_port);
      if (!given->tls.empty()) serve.certificate = given->tls[0], serve.key = given->tls[1];
      return run_serve(serve, stop);
    };
  });
}

}  // namespace palpa::app
