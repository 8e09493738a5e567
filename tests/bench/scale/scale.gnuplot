# Draws what scale_sim printed: gnuplot -e "csv='scale.csv'; svg='scale.svg'" scale.gnuplot
set terminal svg size 860,420 background rgb 'white' font 'sans-serif,12'
set output svg
set datafile separator ','
set multiplot layout 1,2
set logscale x 2
set xtics ('1' 1, '4' 4, '16' 16, '64' 64, '256' 256, '1,024' 1024, '4,096' 4096)
set xrange [1:4200]
set yrange [0:105]
set xlabel 'workers of 16 cores'
set grid
set rmargin 4
set key below
# Column 3: searches, 5: microseconds a sample, 6: round trip, 7: loss, 8: mtu, 10: efficiency.
rows(searches, us) = sprintf("< awk -F, '$3 == %d && $5 == %d && $6 == 0.1 && $7 == 0 && $8 == 1400' %s", \
                             searches, us, csv)
set title '100 searches, 20,000 samples a step'
set ylabel "used of the workers' time [%]"
plot for [us in '1 10 100 1000'] rows(100, int(us)) using 1:10 with linespoints lw 2 \
    title us.' us a sample'
set title '1 ms a sample'
unset ylabel
plot rows(1, 1000) using 1:10 with linespoints lw 2 title '1 search, 20,000 a step', \
     rows(100, 1000) using 1:10 with linespoints lw 2 title '100 searches, 20,000 a step', \
     rows(10000, 1000) using 1:10 with linespoints lw 2 title '10,000 searches, 200 a step'
unset multiplot
