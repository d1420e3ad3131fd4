// A library that is no plug-in.
double lab_constant();
double lab_constant() { return 42.0; }
