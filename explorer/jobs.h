// Background jobs: each on its own thread, shown while running, cancellable.
#pragma once

#include <QObject>
#include <QString>
#include <functional>
#include <list>
#include <memory>
#include <stop_token>
#include <thread>

namespace palpa::explorer {

/// One job at a time per purpose: a new job cancels its predecessor, whose result is dropped. For the window's thread.
class Jobs : public QObject {
  Q_OBJECT
 public:
  enum class Purpose { open, device, draw, slices, tiles, look, feel_again, film };
  explicit Jobs(QObject* parent = nullptr);
  /// Cancels all jobs and joins their threads.
  ~Jobs() override;

  /// Runs `work` on a new thread; it must check its token often. On the window's thread, `done` gets the result or `failed` the
  /// message of the exception. \param what  shown to the user: "reading head.mhd"
  template <class Result>
  void begin(Purpose purpose, const QString& what, std::function<Result(std::stop_token)> work,
             std::function<void(Result)> done, std::function<void(const QString&)> failed) {
    auto result = std::make_shared<std::unique_ptr<Result>>();
    begin_any(
        purpose, what, [work, result](std::stop_token stop) { *result = std::make_unique<Result>(work(stop)); },
        [done, result] { done(std::move(**result)); }, failed);
  }
  void cancel(Purpose purpose);
  void cancel_all();
  bool is_under_way(Purpose purpose) const;
  /// Description of a running job; empty: none.
  QString words() const;

 Q_SIGNALS:
  /// A job began or ended.
  void changed();

 private:
  struct Job {
    Purpose purpose;
    QString what;
    std::stop_source stop{};  ///< requested: the result is dropped
    std::thread thread{};
  };
  void begin_any(Purpose purpose, const QString& what, std::function<void(std::stop_token)> work, std::function<void()> done,
                 std::function<void(const QString&)> failed);
  std::list<std::shared_ptr<Job>> jobs_;
};

}  // namespace palpa::explorer
