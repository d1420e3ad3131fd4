// Sanitizer builds only: libraries stay loaded, so that a leak's report can name where it was made.
extern "C" int dlclose(void*) noexcept;
extern "C" int dlclose(void*) noexcept { return 0; }
