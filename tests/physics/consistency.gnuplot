# Draws worker/kinematics/consistency.svg: paths of measured cars and of the model
# under curves made from them, a consistency check:
#
#     mkdir paths && SOBOX_MEASURED_PATHS=paths build/tests/physics/test_physics_consistency
#     (cd paths && gnuplot ../tests/physics/consistency.gnuplot >../worker/kinematics/consistency.svg)
set terminal svg size 760,330 font "sans-serif,12" background "white"
set datafile separator ","
set key top left reverse Left samplen 2
set grid lc rgb "#dddddd"
set multiplot layout 1,2
set xlabel "time [ms]"
set ylabel "travel forwards [m]"
set xrange [0:150]
plot "all.csv" index 0 using (1e3*$1):2 with lines lw 2 lc rgb "#444444" title "all 333", \
     "all.csv" index 1 using (1e3*$1):2 with points pt 7 ps 0.8 lc rgb "#444444" notitle, \
     "glancing_off.csv" index 0 using (1e3*$1):2 with lines lw 2 lc rgb "#1f77b4" \
         title "glancing off", \
     "glancing_off.csv" index 1 using (1e3*$1):2 with points pt 7 ps 0.8 lc rgb "#1f77b4" notitle, \
     "rotating.csv" index 0 using (1e3*$1):2 with lines lw 2 lc rgb "#d62728" title "rotating", \
     "rotating.csv" index 1 using (1e3*$1):2 with points pt 7 ps 0.8 lc rgb "#d62728" notitle
set xlabel "travel aside [m]"
set autoscale x
unset key
plot "all.csv" index 0 using 3:2 with lines lw 2 lc rgb "#444444", \
     "all.csv" index 1 using 3:2 with points pt 7 ps 0.8 lc rgb "#444444", \
     "glancing_off.csv" index 0 using 3:2 with lines lw 2 lc rgb "#1f77b4", \
     "glancing_off.csv" index 1 using 3:2 with points pt 7 ps 0.8 lc rgb "#1f77b4", \
     "rotating.csv" index 0 using 3:2 with lines lw 2 lc rgb "#d62728", \
     "rotating.csv" index 1 using 3:2 with points pt 7 ps 0.8 lc rgb "#d62728"
unset multiplot
