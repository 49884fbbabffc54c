#pragma once
/// Tells at once that this process ends. The kernel tells of an end only when the last thread has ended and the memory
/// is given back: 10 to 330 ms after `kill -9` where a thread that stands back waits for a processor to die on.

namespace hecaton::services {

/// Hands `fd` to a thread that does nothing but sleep, and alone has it from now on: in a table of descriptors of its
/// own. That thread dies before all work, and with it the line, so the other end reads an end of file within a fraction
/// of a millisecond. Where the thread or the table cannot be had it logs so: then the line ends with the process.
/// To be called once, before the work begins; below 0: there is nobody to tell.
void hold_life_line(int fd);

}  // namespace hecaton::services
