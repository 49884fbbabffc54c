// What owns the precompiled headers of the tests must be a program.
int main() {}
