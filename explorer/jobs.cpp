#include "explorer/jobs.h"

#include <QMetaObject>
#include <exception>
#include <new>

namespace palpa::explorer {

Jobs::Jobs(QObject* parent) : QObject(parent) {}

Jobs::~Jobs() {
  for (const auto& job : jobs_) {
    job->stop.request_stop();
    job->thread.join();
  }
}

void Jobs::begin_any(Purpose purpose, const QString& what, std::function<void(std::stop_token)> work,
                     std::function<void()> done, std::function<void(const QString&)> failed) {
  cancel(purpose);
  auto job = std::make_shared<Job>(Job{.purpose = purpose, .what = what});
  jobs_.push_back(job);
  job->thread = std::thread([this, job, work, done, failed] {
    QString problem;
    try {
      work(job->stop.get_token());
    } catch (const std::bad_alloc&) {
      problem = tr("there is not enough memory for this; try smaller data");
    } catch (const std::exception& error) {
      problem = QString::fromUtf8(error.what());
      if (problem.isEmpty()) problem = tr("unknown error");
    }
    QMetaObject::invokeMethod(
        this,
        [this, job, problem, done, failed] {
          job->thread.join();
          jobs_.remove(job);
          Q_EMIT changed();
          if (job->stop.stop_requested()) return;
          problem.isEmpty() ? done() : failed(problem);
        },
        Qt::QueuedConnection);
  });
  Q_EMIT changed();
}

void Jobs::cancel(Purpose purpose) {
  for (const auto& job : jobs_)
    if (job->purpose == purpose) job->stop.request_stop();
  Q_EMIT changed();
}

void Jobs::cancel_all() {
  for (const auto& job : jobs_) job->stop.request_stop();
  Q_EMIT changed();
}

bool Jobs::is_under_way(Purpose purpose) const {
  for (const auto& job : jobs_)
    if (job->purpose == purpose && !job->stop.stop_requested()) return true;
  return false;
}

QString Jobs::words() const {
  for (const auto& job : jobs_)
    if (!job->stop.stop_requested()) return job->what;
  return {};
}

}  // namespace palpa::explorer
