// occupy PORT: holds a UDP port without sharing it, as a program that is not LCM would, and says
// so, until it is ended by a signal.

#include <arpa/inet.h>
#include <stdio.h>
#include <stdlib.h>
#include <sys/socket.h>
#include <unistd.h>

int main(int argc, char **argv)
{
    const struct sockaddr_in address = {
        .sin_family = AF_INET,
        .sin_port = htons((uint16_t)(argc == 2 ? atoi(argv[1]) : 0)),
    };
    int descriptor = socket(AF_INET, SOCK_DGRAM, 0);
    if (bind(descriptor, (const struct sockaddr *)&address, sizeof address) != 0) {
        perror("occupy");
        return EXIT_FAILURE;
    }
    puts("occupied");
    fflush(stdout);
    pause();
    return EXIT_SUCCESS;
}
