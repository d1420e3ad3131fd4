// Counter of the calling thread's mutex locks and attempts, for one source file of a test program: overrides the C library's
// functions.
#pragma once

#include <dlfcn.h>
#include <pthread.h>

namespace palpa::test {
inline thread_local long locks = 0;

template <class Function>
Function* next_function(const char* name) {
  return reinterpret_cast<Function*>(::dlsym(RTLD_NEXT, name));
}
}  // namespace palpa::test

extern "C" {
int pthread_mutex_lock(pthread_mutex_t* mutex) {
  static auto* const next = palpa::test::next_function<int(pthread_mutex_t*)>("pthread_mutex_lock");
  ++palpa::test::locks;
  return next(mutex);
}
int pthread_mutex_trylock(pthread_mutex_t* mutex) {
  static auto* const next = palpa::test::next_function<int(pthread_mutex_t*)>("pthread_mutex_trylock");
  ++palpa::test::locks;
  return next(mutex);
}
int pthread_rwlock_rdlock(pthread_rwlock_t* lock) {
  static auto* const next = palpa::test::next_function<int(pthread_rwlock_t*)>("pthread_rwlock_rdlock");
  ++palpa::test::locks;
  return next(lock);
}
int pthread_rwlock_wrlock(pthread_rwlock_t* lock) {
  static auto* const next = palpa::test::next_function<int(pthread_rwlock_t*)>("pthread_rwlock_wrlock");
  ++palpa::test::locks;
  return next(lock);
}
}
