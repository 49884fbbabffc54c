// A shared library without devices.
extern "C" int hecaton_test_no_plugin() {
  return 0;
}
