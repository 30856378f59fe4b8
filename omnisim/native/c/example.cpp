// Drives a machine round a curve by what it sees of itself: as far as its drives follow a rate, else it goes as its scene
// says.
//
//   example [step, s]     how often the controller acts; by default every 10 ms

#include <chrono>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <memory>

#include "machine.h"

int main(int count, char **arguments) {
    const double step = count > 1 ? std::atof(arguments[1]) : std::ceil(0.01 / omnisim_grid() - 0.5) * omnisim_grid();
    std::unique_ptr<omnisim_machine, decltype(&omnisim_close)> machine(omnisim_open(), omnisim_close);
    if (!machine) {
        std::fprintf(stderr, "no memory\n");
        return 1;
    }
    const int x = omnisim_find_output("body/position.x");
    const int y = omnisim_find_output("body/position.y");
    const int yaw = omnisim_find_output("body/yaw"); // -1 of a machine free in space
    const auto begun = std::chrono::steady_clock::now();
    for (int i = 0; omnisim_time(machine.get()) < omnisim_end() - 0.5 * step; ++i) {
        const double wanted = 0.5 * omnisim_time(machine.get());
        if (yaw >= 0)
            omnisim_command(machine.get(), 0.3, 0.0, 0.5 + 2.0 * (wanted - omnisim_get(machine.get(), yaw)));
        if (omnisim_step(machine.get(), step) != omnisim_RUNNING) {
            std::fprintf(stderr, "%s\n", omnisim_message(machine.get()));
            return 1;
        }
        if (i % 20 == 19)
            std::printf("t = %.3f s   x = %+.6f m   y = %+.6f m   yaw = %+.6f rad\n", omnisim_time(machine.get()),
                        omnisim_get(machine.get(), x), omnisim_get(machine.get(), y), omnisim_get(machine.get(), yaw));
    }
    const std::chrono::duration<double> took = std::chrono::steady_clock::now() - begun;
    std::printf("%.3f s marched in %.4f s\n", omnisim_time(machine.get()), took.count());
}
