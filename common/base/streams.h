// The three streams that every program is born with, made safe.
//
// A program may be started with standard input, output or error closed (`>&-`, some job systems).
// The next file or socket that it opens would then get their number, and a line meant for the user
// would be written into the journal's or LCM's. And what is still in the buffer of standard output
// when a program ends is lost without a word if the disk is full.
#ifndef SOBOX_COMMON_BASE_STREAMS_H
#define SOBOX_COMMON_BASE_STREAMS_H

// Call it first in main(). Puts a stream that refuses to be used in the place of each closed one,
// and has the end of the program look whether standard output took all: if not, a program that
// would have ended well says so and ends with EXIT_STATUS_FAILED.
void streams_start(void);

#endif
