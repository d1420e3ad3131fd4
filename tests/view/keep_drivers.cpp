// Sanitizer builds only: libraries stay loaded, so that a leak's report has symbols.
extern "C" int dlclose(void*) noexcept;
extern "C" int dlclose(void*) noexcept { return 0; }
