import java.io.DataInputStream;
import java.io.ByteArrayInputStream;
import java.io.EOFException;
import java.lang.reflect.Constructor;
import lcm.logging.Log;
import lcm.spy.LCMTypeDatabase;

// Decodes the messages of a log as lcm-spy does: the type is found by its fingerprint among the
// classes of the path, and made of the bytes. A line a message: channel, type, and for search_status_t
// what it says.
class Decode {
    public static void main(String[] arguments) throws Exception {
        LCMTypeDatabase types = new LCMTypeDatabase();
        Log log = new Log(arguments[0], "r");
        try {
            for (;;)
                tell(types, log.readNext());
        } catch (EOFException end) {
            log.close();
        }
    }

    static void tell(LCMTypeDatabase types, Log.Event event) throws Exception {
        if (!event.channel.startsWith("SOBOX"))
            return; // LCM's own
        DataInputStream head = new DataInputStream(new ByteArrayInputStream(event.data));
        Class<?> type = types.getClassByFingerprint(head.readLong());
        if (type == null) {
            System.out.println(event.channel + " unknown");
            return;
        }
        Constructor<?> make = type.getConstructor(java.io.DataInput.class);
        Object message = make.newInstance(
            new DataInputStream(new ByteArrayInputStream(event.data)));
        String words = "";
        if (type.getSimpleName().equals("search_status_t"))
            for (String name : new String[] {"standing", "step", "evaluations", "log_volume"})
                words += " " + name + "=" + type.getField(name).get(message);
        System.out.println(event.channel + " " + type.getName() + words);
    }
}
