"""The words of the pages of equations in other languages: English -> Portuguese, German, French, Spanish.

A phrase that stands on a page and not here is an error in tests/paper/test_languages.py.
"""

from collections.abc import Mapping

LANGUAGES = ("en", "pt", "de", "fr", "es")

PHRASES: Mapping[str, tuple[str, str, str, str]] = {
    # ---- what a page is
    "{0}: the equations of motion": (
        "{0}: as equações de movimento", "{0}: die Bewegungsgleichungen", "{0} : les équations du mouvement",
        "{0}: las ecuaciones de movimiento"),
    "{0}: an exercise": ("{0}: um exercício", "{0}: eine Aufgabe", "{0} : un exercice", "{0}: un ejercicio"),
    "Problem": ("Problema", "Aufgabe", "Problème", "Problema"),
    "Derive the equation of motion of each coordinate by Lagrange's equations.": (
        "Deduza a equação de movimento de cada coordenada pelas equações de Lagrange.",
        "Leiten Sie die Bewegungsgleichung jeder Koordinate mit den Lagrangeschen Gleichungen her.",
        "Établir l'équation du mouvement de chaque coordonnée par les équations de Lagrange.",
        "Deduzca la ecuación de movimiento de cada coordenada mediante las ecuaciones de Lagrange."),
    "Derived by Lagrangia from the model's energies.": (
        "Deduzido pelo Lagrangia a partir das energias do modelo.", "Von Lagrangia aus den Energien des Modells hergeleitet.",
        "Établi par Lagrangia à partir des énergies du modèle.", "Deducido por Lagrangia a partir de las energías del modelo."),
    # ---- attitudes
    "Euler's equations of angular velocities, with small turns {0}, {1}, {2} about the axes that turn along,": (
        "As equações de Euler das velocidades angulares, com pequenas rotações {0}, {1}, {2} em torno dos eixos que giram junto,",
        "Die Eulerschen Gleichungen der Winkelgeschwindigkeiten, mit kleinen Drehungen {0}, {1}, {2} um die mitgedrehten Achsen,",
        "Les équations d'Euler des vitesses angulaires, avec de petites rotations {0}, {1}, {2} autour des axes entraînés,",
        "Las ecuaciones de Euler de las velocidades angulares, con pequeños giros {0}, {1}, {2} en torno a los ejes que giran,"),
    "Of the attitude {0}: {1} are its angular velocity, in the turned axes, {2} its unit quaternion, the real part first.": (
        "Da orientação {0}: {1} são sua velocidade angular, nos eixos girados, {2} seu quatérnio unitário, a parte real "
        "primeiro.",
        "Von der Drehlage {0}: {1} sind ihre Winkelgeschwindigkeit in den gedrehten Achsen, {2} ihr Einheitsquaternion, der "
        "Realteil zuerst.",
        "De l'orientation {0} : {1} sont sa vitesse angulaire, dans les axes tournés, {2} son quaternion unitaire, la partie "
        "réelle d'abord.",
        "De la orientación {0}: {1} son su velocidad angular, en los ejes girados, {2} su cuaternión unitario, primero la parte "
        "real."),
    "Attitudes follow by": ("As orientações seguem de", "Die Drehlagen folgen aus", "Les orientations suivent de",
                            "Las orientaciones se siguen de"),
    # ---- where coordinates are singular
    "These coordinates are singular where {0}: there {1}, and the equations give no accelerations.": (
        "Estas coordenadas são singulares onde {0}: ali {1}, e as equações não dão acelerações.",
        "Diese Koordinaten sind singulär, wo {0}: Dort ist {1}, und die Gleichungen geben keine Beschleunigungen.",
        "Ces coordonnées sont singulières là où {0} : on y a {1}, et les équations ne donnent pas d'accélérations.",
        "Estas coordenadas son singulares donde {0}: allí {1}, y las ecuaciones no dan aceleraciones."),
    "At this point {0}: the coordinates are singular there, and do not tell all small motions.": (
        "Neste ponto {0}: ali as coordenadas são singulares e não descrevem todos os pequenos movimentos.",
        "In diesem Punkt ist {0}: Dort sind die Koordinaten singulär und beschreiben nicht alle kleinen Bewegungen.",
        "En ce point {0} : les coordonnées y sont singulières et ne décrivent pas tous les petits mouvements.",
        "En este punto {0}: allí las coordenadas son singulares y no describen todos los pequeños movimientos."),
    # ---- the system
    "System": ("Sistema", "System", "Système", "Sistema"),
    "Assumed: gravity acts": ("Hipóteses: a gravidade atua", "Annahmen: Die Schwerkraft wirkt", "Hypothèses : la pesanteur agit",
                              "Hipótesis: actúa la gravedad"),
    "Assumed: no gravity acts": ("Hipóteses: a gravidade não atua", "Annahmen: Es wirkt keine Schwerkraft",
                                 "Hypothèses : la pesanteur n'agit pas", "Hipótesis: no actúa la gravedad"),
    "Assumed: gravity does no work here": (
        "Hipóteses: a gravidade não realiza trabalho aqui", "Annahmen: Die Schwerkraft leistet hier keine Arbeit",
        "Hypothèses : la pesanteur ne travaille pas ici", "Hipótesis: la gravedad no realiza trabajo aquí"),
    "joints are ideal, their forces do no virtual work": (
        "as ligações são ideais, suas forças não realizam trabalho virtual",
        "die Gelenke sind ideal, ihre Kräfte leisten keine virtuelle Arbeit",
        "les liaisons sont parfaites, leurs efforts ne fournissent aucun travail virtuel",
        "las uniones son ideales, sus fuerzas no realizan trabajo virtual"),
    "{0}, given in time, has a potential": (
        "{0}, dada no tempo, tem um potencial", "{0}, als Funktion der Zeit gegeben, hat ein Potential",
        "{0}, donnée en fonction du temps, a un potentiel", "{0}, dada en el tiempo, tiene un potencial"),
    "{0}, given in time, have potentials": (
        "{0}, dadas no tempo, têm potenciais", "{0}, als Funktionen der Zeit gegeben, haben Potentiale",
        "{0}, données en fonction du temps, ont des potentiels", "{0}, dadas en el tiempo, tienen potenciales"),
    "{0}: by virtual work alone": ("{0}: apenas pelo trabalho virtual", "{0}: allein durch virtuelle Arbeit",
                                   "{0} : par le seul travail virtuel", "{0}: solo por el trabajo virtual"),
    "a force of the model": ("uma força do modelo", "eine Kraft des Modells", "une force du modèle", "una fuerza del modelo"),
    "All that follows is for {0}.": ("Tudo o que segue vale para {0}.", "Alles Folgende gilt für {0}.",
                                     "Tout ce qui suit vaut pour {0}.", "Todo lo que sigue vale para {0}."),
    "Events: between them the equations hold.": (
        "Eventos: entre eles valem as equações.", "Ereignisse: Zwischen ihnen gelten die Gleichungen.",
        "Événements : entre eux, les équations sont valables.", "Eventos: entre ellos valen las ecuaciones."),
    # ---- coordinates and data
    "Coordinates": ("Coordenadas", "Koordinaten", "Coordonnées", "Coordenadas"),
    "The position is known by one generalised coordinate, which nothing ties: 1 degree of freedom.": (
        "A posição é dada por uma coordenada generalizada, livre de vínculos: 1 grau de liberdade.",
        "Die Lage ist durch eine verallgemeinerte Koordinate bestimmt, die nichts bindet: 1 Freiheitsgrad.",
        "La position est donnée par une coordonnée généralisée, que rien ne lie : 1 degré de liberté.",
        "La posición se conoce por una coordenada generalizada, que nada liga: 1 grado de libertad."),
    "The position is known by {0} generalised coordinates, which nothing ties: {0} degrees of freedom.": (
        "A posição é dada por {0} coordenadas generalizadas, livres de vínculos: {0} graus de liberdade.",
        "Die Lage ist durch {0} verallgemeinerte Koordinaten bestimmt, die nichts bindet: {0} Freiheitsgrade.",
        "La position est donnée par {0} coordonnées généralisées, que rien ne lie : {0} degrés de liberté.",
        "La posición se conoce por {0} coordenadas generalizadas, que nada liga: {0} grados de libertad."),
    "Generalised coordinates: {0}; constraints that tie them: {1}; degrees of freedom that are left: {2}.": (
        "Coordenadas generalizadas: {0}; vínculos entre elas: {1}; graus de liberdade restantes: {2}.",
        "Verallgemeinerte Koordinaten: {0}; Bindungen zwischen ihnen: {1}; verbleibende Freiheitsgrade: {2}.",
        "Coordonnées généralisées : {0} ; liaisons entre elles : {1} ; degrés de liberté restants : {2}.",
        "Coordenadas generalizadas: {0}; ligaduras entre ellas: {1}; grados de libertad que quedan: {2}."),
    "The virtual displacements {0} are arbitrary, simultaneous, and taken at a fixed time.": (
        "Os deslocamentos virtuais {0} são arbitrários, simultâneos e tomados a tempo fixo.",
        "Die virtuellen Verschiebungen {0} sind beliebig, gleichzeitig und bei festgehaltener Zeit genommen.",
        "Les déplacements virtuels {0} sont arbitraires, simultanés et pris à temps fixé.",
        "Los desplazamientos virtuales {0} son arbitrarios, simultáneos y tomados a tiempo fijo."),
    "The virtual displacements {0} are arbitrary but for the constraints, simultaneous, and taken at a fixed time.": (
        "Os deslocamentos virtuais {0} são arbitrários, respeitados os vínculos, simultâneos e tomados a tempo fixo.",
        "Die virtuellen Verschiebungen {0} sind bis auf die Bindungen beliebig, gleichzeitig und bei festgehaltener Zeit "
        "genommen.",
        "Les déplacements virtuels {0} sont arbitraires aux liaisons près, simultanés et pris à temps fixé.",
        "Los desplazamientos virtuales {0} son arbitrarios salvo las ligaduras, simultáneos y tomados a tiempo fijo."),
    "angle of a floating body": ("ângulo de um corpo livre", "Winkel eines freien Körpers", "angle d'un corps libre",
                                 "ángulo de un cuerpo libre"),
    "of a floating body": ("de um corpo livre", "eines freien Körpers", "d'un corps libre", "de un cuerpo libre"),
    "given by the others": ("dada pelas outras", "durch die anderen gegeben", "donnée par les autres", "dada por las otras"),
    "in the model": ("no modelo", "im Modell", "dans le modèle", "en el modelo"),
    "unit": ("unidade", "Einheit", "unité", "unidad"),
    "value": ("valor", "Wert", "valeur", "valor"),
    "Data": ("Dados", "Daten", "Données", "Datos"),
    "Given:": ("Dado:", "Gegeben:", "On donne :", "Dado:"),
    "{0} is {1}": ("{0} é {1}", "{0} ist {1}", "{0} est {1}", "{0} es {1}"),
    # ---- positions and the principle
    "Positions, velocities, virtual displacements": (
        "Posições, velocidades, deslocamentos virtuais", "Lagen, Geschwindigkeiten, virtuelle Verschiebungen",
        "Positions, vitesses, déplacements virtuels", "Posiciones, velocidades, desplazamientos virtuales"),
    "The points that energies and forces depend on, their velocities, and their virtual displacements at a fixed time:": (
        "Os pontos de que dependem as energias e as forças, suas velocidades e seus deslocamentos virtuais a tempo fixo:",
        "Die Punkte, von denen Energien und Kräfte abhängen, ihre Geschwindigkeiten und ihre virtuellen Verschiebungen bei "
        "festgehaltener Zeit:",
        "Les points dont dépendent les énergies et les forces, leurs vitesses et leurs déplacements virtuels à temps fixé :",
        "Los puntos de los que dependen las energías y las fuerzas, sus velocidades y sus desplazamientos virtuales a tiempo "
        "fijo:"),
    "The principle of virtual work": ("O princípio dos trabalhos virtuais", "Das Prinzip der virtuellen Arbeit",
                                      "Le principe des travaux virtuels", "El principio de los trabajos virtuales"),
    "Ideal joints do no virtual work, so that by d'Alembert's principle": (
        "Ligações ideais não realizam trabalho virtual; pelo princípio de d'Alembert",
        "Ideale Gelenke leisten keine virtuelle Arbeit; nach dem Prinzip von d'Alembert gilt",
        "Les liaisons parfaites ne fournissent aucun travail virtuel ; d'après le principe de d'Alembert",
        "Las uniones ideales no realizan trabajo virtual; por el principio de d'Alembert"),
    "The parts of this virtual work are here": (
        "As partes deste trabalho virtual são aqui", "Die Anteile dieser virtuellen Arbeit sind hier",
        "Les parts de ce travail virtuel sont ici", "Las partes de este trabajo virtual son aquí"),
    "and their sum is 0: {0}.": ("e sua soma é 0: {0}.", "und ihre Summe ist 0: {0}.", "et leur somme est 0 : {0}.",
                                 "y su suma es 0: {0}."),
    "With {0} the inertial part is one of the coordinates,": (
        "Com {0}, a parte inercial passa às coordenadas,", "Mit {0} wird der Trägheitsanteil einer der Koordinaten,",
        "Avec {0}, la part d'inertie s'écrit dans les coordonnées,", "Con {0}, la parte de inercia pasa a las coordenadas,"),
    "here": ("aqui", "hier", "ici", "aquí"),
    "As the {0} are independent of each other, each bracket is 0.": (
        "Como os {0} são independentes entre si, cada parêntese é 0.",
        "Da die {0} voneinander unabhängig sind, ist jede Klammer 0.",
        "Les {0} étant indépendants les uns des autres, chaque parenthèse est nulle.",
        "Como los {0} son independientes entre sí, cada paréntesis es 0."),
    "As {0} is arbitrary, the bracket is 0.": (
        "Como {0} é arbitrário, o parêntese é 0.", "Da {0} beliebig ist, ist die Klammer 0.",
                                               "{0} étant arbitraire, la parenthèse est nulle.",
                                               "Como {0} es arbitrario, el paréntesis es 0."),
    "The {0} are not independent: they keep the constraints. With a multiplier for each constraint, {1} joins each equation, "
    "whose "
    "bracket is then 0.": (
        "Os {0} não são independentes: respeitam os vínculos. Com um multiplicador para cada vínculo, {1} entra em cada equação, "
        "cujo parêntese é então 0.",
        "Die {0} sind nicht unabhängig: Sie halten die Bindungen ein. Mit einem Multiplikator je Bindung tritt {1} zu jeder "
        "Gleichung, "
        "deren Klammer dann 0 ist.",
        "Les {0} ne sont pas indépendants : ils respectent les liaisons. Avec un multiplicateur par liaison, {1} s'ajoute à "
        "chaque "
        "équation, dont la parenthèse est alors nulle.",
        "Los {0} no son independientes: respetan las ligaduras. Con un multiplicador por ligadura, {1} se añade a cada "
        "ecuación, cuyo "
        "paréntesis es entonces 0."),
    "The inertial work of all bodies, sorted by the {0}, has the derivatives of {1} as factors, a coordinate a line:": (
        "O trabalho de inércia de todos os corpos, ordenado pelos {0}, tem as derivadas de {1} como fatores, uma coordenada "
        "por linha:",
        "Die Trägheitsarbeit aller Körper, nach den {0} geordnet, hat die Ableitungen von {1} als Faktoren, eine Koordinate "
        "je Zeile:",
        "Le travail d'inertie de tous les corps, ordonné suivant les {0}, a pour facteurs les dérivées de {1}, une coordonnée "
        "par "
        "ligne :",
        "El trabajo de inercia de todos los cuerpos, ordenado por los {0}, tiene como factores las derivadas de {1}, una "
        "coordenada "
        "por línea:"),
    # ---- energies
    "Kinetic energy": ("Energia cinética", "Kinetische Energie", "Énergie cinétique", "Energía cinética"),
    "Potential energy": ("Energia potencial", "Potentielle Energie", "Énergie potentielle", "Energía potencial"),
    "Dissipation function": ("Função de dissipação", "Dissipationsfunktion", "Fonction de dissipation", "Función de disipación"),
    "Body by body:": ("Corpo a corpo:", "Körper für Körper:", "Corps par corps :", "Cuerpo por cuerpo:"),
    "with the velocities put in:": ("com as velocidades substituídas:", "mit eingesetzten Geschwindigkeiten:",
                                    "en y portant les vitesses :", "con las velocidades sustituidas:"),
    "In all:": ("No total:", "Insgesamt:", "Au total :", "En total:"),
    "Elastic:": ("Elástica:", "Elastisch:", "Élastique :", "Elástica:"),
    "Of gravity:": ("Da gravidade:", "Der Schwerkraft:", "De la pesanteur :", "De la gravedad:"),
    "Elastic, and of what acts from outside (weights, sources):": (
        "Elástica, e do que atua de fora (pesos, fontes):", "Elastisch, und von äußeren Wirkungen (Gewichte, Quellen):",
        "Élastique, et de ce qui agit de l'extérieur (poids, sources) :",
        "Elástica, y de lo que actúa desde fuera (pesos, fuentes):"),
    "collected:": ("reunida:", "zusammengefasst:", "regroupée :", "reunida:"),
    "Each damper by the rate of its stretch:": (
        "Cada amortecedor pela taxa de seu alongamento:", "Jeder Dämpfer durch die Rate seiner Längung:",
        "Chaque amortisseur par la vitesse de son allongement :", "Cada amortiguador por la velocidad de su alargamiento:"),
    "For linear dampers {0} is half the power that they take out.": (
        "Para amortecedores lineares, {0} é a metade da potência que eles retiram.",
        "Bei linearen Dämpfern ist {0} die Hälfte der Leistung, die sie entziehen.",
        "Pour des amortisseurs linéaires, {0} est la moitié de la puissance qu'ils prélèvent.",
        "Para amortiguadores lineales, {0} es la mitad de la potencia que extraen."),
    # ---- forces
    "Generalised forces": ("Forças generalizadas", "Verallgemeinerte Kräfte", "Forces généralisées", "Fuerzas generalizadas"),
    "Conservative, by {0} {1}:": ("Conservativas, por {0} {1}:", "Konservativ, aus {0} {1}:", "Conservatives, par {0} {1} :",
                                  "Conservativas, por {0} {1}:"),
    "Non-conservative, by {0} {1}:": ("Não conservativas, por {0} {1}:", "Nicht konservativ, aus {0} {1}:",
                                      "Non conservatives, par {0} {1} :", "No conservativas, por {0} {1}:"),
    "By their virtual work, force by stretch,": (
        "Por seu trabalho virtual, força a força,", "Aus ihrer virtuellen Arbeit, Kraft mal Längung,",
        "Par leur travail virtuel, force par allongement,", "Por su trabajo virtual, fuerza por alargamiento,"),
    "and the factors of the {0} are again {1}: both ways agree.": (
        "e os fatores dos {0} são de novo {1}: os dois caminhos concordam.",
        "und die Faktoren der {0} sind wieder {1}: Beide Wege stimmen überein.",
        "et les facteurs des {0} sont de nouveau {1} : les deux voies concordent.",
        "y los factores de los {0} son de nuevo {1}: ambos caminos coinciden."),
    "Of the sources, by their virtual work:": (
        "Das fontes, por seu trabalho virtual:", "Der Quellen, aus ihrer virtuellen Arbeit:",
        "Des sources, par leur travail virtuel :", "De las fuentes, por su trabajo virtual:"),
    "Applied, by their virtual work:": ("Aplicadas, por seu trabalho virtual:", "Eingeprägt, aus ihrer virtuellen Arbeit:",
                                        "Appliquées, par leur travail virtuel :", "Aplicadas, por su trabajo virtual:"),
    "Of rates, by their virtual work:": ("Das velocidades, por seu trabalho virtual:", "Von Raten, aus ihrer virtuellen Arbeit:",
                                         "Des vitesses, par leur travail virtuel :",
                                         "De las velocidades, por su trabajo virtual:"),
    "which is again their part of {0}: a source with a potential may stand on either side.": (
        "que é de novo sua parte de {0}: uma fonte com potencial pode ficar de qualquer lado.",
        "was wieder ihr Anteil von {0} ist: Eine Quelle mit Potential kann auf beiden Seiten stehen.",
        "qui est de nouveau leur part de {0} : une source à potentiel peut figurer d'un côté ou de l'autre.",
        "que es de nuevo su parte de {0}: una fuente con potencial puede estar en cualquiera de los lados."),
    "Of {0}:": ("De {0}:", "Von {0}:", "De {0} :", "De {0}:"),
    # ---- constraints and events
    "Constraints": ("Vínculos", "Bindungen", "Liaisons", "Ligaduras"),
    "Constraints on the rates": ("Vínculos nas velocidades", "Bindungen der Geschwindigkeiten", "Liaisons sur les vitesses",
                                 "Ligaduras en las velocidades"),
    "Constraints, the last on the rates": (
        "Vínculos, os últimos nas velocidades", "Bindungen, die letzten der Geschwindigkeiten",
        "Liaisons, les dernières sur les vitesses", "Ligaduras, las últimas en las velocidades"),
    "{0}, with the multiplier {1}:": ("{0}, com o multiplicador {1}:", "{0}, mit dem Multiplikator {1}:",
                                      "{0}, avec le multiplicateur {1} :", "{0}, con el multiplicador {1}:"),
    "{0}, with the multipliers {1}:": ("{0}, com os multiplicadores {1}:", "{0}, mit den Multiplikatoren {1}:",
                                       "{0}, avec les multiplicateurs {1} :", "{0}, con los multiplicadores {1}:"),
    "with the slopes": ("com as derivadas", "mit den Ableitungen", "avec les dérivées", "con las derivadas"),
    "Each multiplier is the force that keeps its constraint: {0}.": (
        "Cada multiplicador é a força que mantém seu vínculo: {0}.",
        "Jeder Multiplikator ist die Kraft, die seine Bindung hält: {0}.",
        "Chaque multiplicateur est la force qui maintient sa liaison : {0}.",
        "Cada multiplicador es la fuerza que mantiene su ligadura: {0}."),
    "{0} of '{1}'": ("{0} de '{1}'", "{0} von '{1}'", "{0} de '{1}'", "{0} de '{1}'"),
    "{0} the torque in {1}, on {2}": ("{0} o momento em {1}, sobre {2}", "{0} das Moment in {1}, auf {2}",
                                      "{0} le moment en {1}, sur {2}", "{0} el momento en {1}, sobre {2}"),
    "{0} the force across {1}, on {2}": ("{0} a força transversal a {1}, sobre {2}", "{0} die Kraft quer zu {1}, auf {2}",
                                         "{0} la force transversale à {1}, sur {2}",
                                         "{0} la fuerza transversal a {1}, sobre {2}"),
    "{0} the force along {1} in {2}, on {3}": (
        "{0} a força ao longo de {1} em {2}, sobre {3}", "{0} die Kraft längs {1} in {2}, auf {3}",
        "{0} la force suivant {1} en {2}, sur {3}", "{0} la fuerza a lo largo de {1} en {2}, sobre {3}"),
    "A support jumps at times, or its rate: there {0} stays as it is, but for what holds the scene and the impulses of "
    "dampers, and "
    "the equations hold in between.": (
        "Um apoio salta em certos instantes, ou sua velocidade: ali {0} permanece, a menos do que segura o sistema e dos "
        "impulsos dos "
        "amortecedores, e as equações valem entre eles.",
        "Eine Lagerung oder ihre Geschwindigkeit springt zuweilen: Dort bleibt {0}, bis auf das, was die Szene hält, und die "
        "Stöße der "
        "Dämpfer, und die Gleichungen gelten dazwischen.",
        "Un appui, ou sa vitesse, saute à certains instants : {0} y demeure, à ce qui tient le système et aux impulsions des "
        "amortisseurs près, et les équations valent entre eux.",
        "Un apoyo salta en ciertos instantes, o su velocidad: allí {0} permanece, salvo lo que sujeta el sistema y los "
        "impulsos de los "
        "amortiguadores, y las ecuaciones valen entre ellos."),
    "At events rates jump: {0}, by an impulse that works on what it is the rate of. In between the equations hold.": (
        "Nos eventos as velocidades saltam: {0}, por um impulso que atua sobre aquilo de que é a velocidade. Entre eles valem as "
        "equações.",
        "An Ereignissen springen Geschwindigkeiten: {0}, durch einen Stoß auf das, dessen Rate es ist. Dazwischen gelten die "
        "Gleichungen.",
        "Aux événements, les vitesses sautent : {0}, par une impulsion sur ce dont c'est la vitesse. Entre eux, les équations "
        "sont "
        "valables.",
        "En los eventos las velocidades saltan: {0}, por un impulso sobre aquello de lo que es la velocidad. Entre ellos "
        "valen las "
        "ecuaciones."),
    "where {0} comes to be positive, {1}": ("onde {0} se torna positivo, {1}", "wo {0} positiv wird, {1}",
                                            "là où {0} devient positif, {1}", "donde {0} se hace positivo, {1}"),
    "{0} becomes {1}": ("{0} passa a {1}", "wird {0} zu {1}", "{0} devient {1}", "{0} pasa a {1}"),
    # ---- the equations
    "Lagrange's equations": (
        "Equações de Lagrange", "Lagrangesche Gleichungen", "Équations de Lagrange", "Ecuaciones de Lagrange"),
    "Lagrange's equations, form {0} ({1}):": (
        "Equações de Lagrange, forma {0} ({1}):", "Lagrangesche Gleichungen, Form {0} ({1}):",
        "Équations de Lagrange, forme {0} ({1}) :", "Ecuaciones de Lagrange, forma {0} ({1}):"),
    "For {0}:": ("Para {0}:", "Für {0}:", "Pour {0} :", "Para {0}:"),
    "put together:": ("reunindo:", "zusammengesetzt:", "en réunissant :", "reuniendo:"),
    "in order:": ("em ordem:", "geordnet:", "en ordre :", "en orden:"),
    "so that": ("de modo que", "sodass", "d'où", "de modo que"),
    "give": ("dão", "ergeben", "donnent", "dan"),
    "gives": ("dá", "ergibt", "donne", "da"),
    "with": ("com", "mit", "avec", "con"),
    "and": ("e", "und", "et", "y"),
    "where": ("onde", "wobei", "où", "donde"),
    "In matrix form": ("Em forma matricial", "In Matrixform", "Sous forme matricielle", "En forma matricial"),
    # ---- small motion
    "Small motion": ("Pequenos movimentos", "Kleine Bewegungen", "Petits mouvements", "Pequeños movimientos"),
    "Small motion about the equilibrium{0}{1}:": (
        "Pequenos movimentos em torno do equilíbrio{0}{1}:", "Kleine Bewegungen um die Gleichgewichtslage{0}{1}:",
        "Petits mouvements autour de l'équilibre{0}{1} :", "Pequeños movimientos alrededor del equilibrio{0}{1}:"),
    "Small motion about a point that is no equilibrium{0}{1}:": (
        "Pequenos movimentos em torno de um ponto que não é de equilíbrio{0}{1}:",
        "Kleine Bewegungen um einen Punkt, der keine Gleichgewichtslage ist{0}{1}:",
        "Petits mouvements autour d'un point qui n'est pas d'équilibre{0}{1} :",
        "Pequeños movimientos alrededor de un punto que no es de equilibrio{0}{1}:"),
    ", with the multipliers": (", com os multiplicadores", ", mit den Multiplikatoren", ", avec les multiplicateurs",
                               ", con los multiplicadores"),
    ", found with the parameters' values": (
        ", obtido com os valores dos parâmetros", ", gefunden mit den Werten der Parameter",
        ", trouvé avec les valeurs des paramètres", ", hallado con los valores de los parámetros"),
    "The equations are linear as they stand.": (
        "As equações já são lineares.", "Die Gleichungen sind schon linear.", "Les équations sont déjà linéaires.",
        "Las ecuaciones ya son lineales."),
    "Products of small quantities are left out:": (
        "Desprezam-se produtos de quantidades pequenas:", "Produkte kleiner Größen werden weggelassen:",
        "Les produits de petites quantités sont négligés :", "Se desprecian los productos de cantidades pequeñas:"),
    "Products of small quantities are left out, as in {0}:": (
        "Desprezam-se produtos de quantidades pequenas, como em {0}:", "Produkte kleiner Größen werden weggelassen, wie in {0}:",
        "Les produits de petites quantités sont négligés, comme dans {0} :",
        "Se desprecian los productos de cantidades pequeñas, como en {0}:"),
    "What is given moves about a place of its own:": (
        "O que é dado se move em torno de um lugar próprio:", "Was gegeben ist, bewegt sich um einen eigenen Ort:",
        "Ce qui est donné se meut autour de sa propre position :", "Lo dado se mueve alrededor de un lugar propio:"),
    "Coefficients that vary with time are taken at a standstill: with supports at rest, and without loads.": (
        "Coeficientes que variam no tempo são tomados em repouso: com apoios parados e sem cargas.",
        "Zeitabhängige Koeffizienten sind im Stillstand genommen: mit ruhenden Lagerungen und ohne Lasten.",
        "Les coefficients variables dans le temps sont pris à l'arrêt : appuis immobiles, sans charges.",
        "Los coeficientes que varían en el tiempo se toman en reposo: con los apoyos quietos y sin cargas."),
    "The constraints give": ("Os vínculos dão", "Die Bindungen ergeben", "Les liaisons donnent", "Las ligaduras dan"),
    "and without multipliers the equation of motion is": (
        "e sem multiplicadores a equação de movimento é", "und ohne Multiplikatoren ist die Bewegungsgleichung",
        "et sans multiplicateurs l'équation du mouvement est", "y sin multiplicadores la ecuación de movimiento es"),
    "and without multipliers the equations of motion are": (
        "e sem multiplicadores as equações de movimento são", "und ohne Multiplikatoren sind die Bewegungsgleichungen",
        "et sans multiplicateurs les équations du mouvement sont", "y sin multiplicadores las ecuaciones de movimiento son"),
    # ---- constants of the motion
    "Constants of the motion": (
        "Constantes do movimento", "Erhaltungsgrößen", "Constantes du mouvement", "Constantes del movimiento"),
    "Between events:": ("Entre eventos:", "Zwischen Ereignissen:", "Entre les événements :", "Entre eventos:"),
    "one of Euler's angles": ("um dos ângulos de Euler", "einer der Eulerschen Winkel", "un des angles d'Euler",
                              "uno de los ángulos de Euler"),
    "As these momenta are constant, {0} alone is left to move, in an effective potential:": (
        "Como esses momentos são constantes, só resta mover-se {0}, num potencial efetivo:",
        "Da diese Impulse konstant sind, bewegt sich nur noch {0}, in einem effektiven Potential:",
        "Ces moments étant constants, seul {0} reste à déterminer, dans un potentiel effectif :",
        "Como estos momentos son constantes, solo queda por moverse {0}, en un potencial efectivo:"),
    "{0} is cyclic: its momentum is constant.": (
        "{0} é cíclica: seu momento é constante.", "{0} ist zyklisch: Ihr Impuls ist konstant.",
        "{0} est cyclique : son moment est constant.", "{0} es cíclica: su momento es constante."),
    "About its own {0} axis nothing changes the angular momentum of {1}: it is constant.": (
        "Em torno do próprio eixo {0} nada altera o momento angular de {1}: ele é constante.",
        "Um die eigene Achse {0} ändert nichts den Drehimpuls von {1}: Er ist konstant.",
        "Autour de son propre axe {0} rien ne change le moment cinétique de {1} : il est constant.",
        "Alrededor de su propio eje {0} nada cambia el momento angular de {1}: es constante."),
    "About the {0} axis of what carries it nothing turns {1}: its angular momentum about it is constant.": (
        "Em torno do eixo {0} do que o sustenta nada gira {1}: seu momento angular em torno dele é constante.",
        "Um die Achse {0} dessen, was es trägt, dreht nichts {1}: Der Drehimpuls um sie ist konstant.",
        "Autour de l'axe {0} de ce qui le porte rien ne fait tourner {1} : son moment cinétique autour de lui est constant.",
        "Alrededor del eje {0} de lo que lo lleva nada hace girar {1}: su momento angular respecto a él es constante."),
    "The loads are constant and nothing is lost: the energy is constant.": (
        "As cargas são constantes e nada se perde: a energia é constante.",
        "Die Lasten sind konstant und nichts geht verloren: Die Energie ist konstant.",
        "Les charges sont constantes et rien ne se perd : l'énergie est constante.",
        "Las cargas son constantes y nada se pierde: la energía es constante."),
    "Nothing depends on time and nothing is lost: the energy is constant.": (
        "Nada depende do tempo e nada se perde: a energia é constante.",
        "Nichts hängt von der Zeit ab und nichts geht verloren: Die Energie ist konstant.",
        "Rien ne dépend du temps et rien ne se perd : l'énergie est constante.",
        "Nada depende del tiempo y nada se pierde: la energía es constante."),
    "Nothing depends on time and nothing is lost: Jacobi's integral is constant.": (
        "Nada depende do tempo e nada se perde: a integral de Jacobi é constante.",
        "Nichts hängt von der Zeit ab und nichts geht verloren: Das Jacobi-Integral ist konstant.",
        "Rien ne dépend du temps et rien ne se perd : l'intégrale de Jacobi est constante.",
        "Nada depende del tiempo y nada se pierde: la integral de Jacobi es constante."),
    # ---- checks
    "Checks": ("Verificações", "Proben", "Vérifications", "Comprobaciones"),
    "Each term of the equations has one unit, {0}.": (
        "Cada termo das equações tem uma só unidade, {0}.", "Jeder Term der Gleichungen hat eine Einheit, {0}.",
        "Chaque terme des équations a une même unité, {0}.", "Cada término de las ecuaciones tiene una sola unidad, {0}."),
    "{0}: {1}": ("{0}: {1}", "{0}: {1}", "{0} : {1}", "{0}: {1}"),
    "{0} is symmetric and positive:": ("{0} é simétrica e positiva:", "{0} ist symmetrisch und positiv:",
                                       "{0} est symétrique et positive :", "{0} es simétrica y positiva:"),
    "{0} is symmetric, and positive at {1} positions taken at random.": (
        "{0} é simétrica, e positiva em {1} posições tomadas ao acaso.",
        "{0} ist symmetrisch, und positiv an {1} zufälligen Lagen.",
        "{0} est symétrique, et positive en {1} positions prises au hasard.",
        "{0} es simétrica, y positiva en {1} posiciones tomadas al azar."),
    "{0} is symmetric but not positive: not every motion has kinetic energy.": (
        "{0} é simétrica mas não positiva: nem todo movimento tem energia cinética.",
        "{0} ist symmetrisch, aber nicht positiv: Nicht jede Bewegung hat kinetische Energie.",
        "{0} est symétrique mais pas positive : tout mouvement n'a pas d'énergie cinétique.",
        "{0} es simétrica pero no positiva: no todo movimiento tiene energía cinética."),
    "The energy theorem: what has no potential, and sources, change the energy by their power:": (
        "O teorema da energia: o que não tem potencial, e as fontes, mudam a energia por sua potência:",
        "Der Energiesatz: Was kein Potential hat, und Quellen, ändern die Energie um ihre Leistung:",
        "Le théorème de l'énergie : ce qui n'a pas de potentiel, et les sources, changent l'énergie de leur puissance :",
        "El teorema de la energía: lo que no tiene potencial, y las fuentes, cambian la energía por su potencia:"),
    "The energy theorem, with {0} of weights: what has no potential, and sources, change the energy by their power:": (
        "O teorema da energia, com {0} dos pesos: o que não tem potencial, e as fontes, mudam a energia por sua potência:",
        "Der Energiesatz, mit {0} der Gewichte: Was kein Potential hat, und Quellen, ändern die Energie um ihre Leistung:",
        "Le théorème de l'énergie, avec {0} des poids : ce qui n'a pas de potentiel, et les sources, changent l'énergie de leur "
        "puissance :",
        "El teorema de la energía, con {0} de los pesos: lo que no tiene potencial, y las fuentes, cambian la energía por su "
        "potencia:"),
    # ---- scenes too large to read
    "Coordinates: {0}; constraints: {1}; terms in the kinetic energy alone: {2}.": (
        "Coordenadas: {0}; vínculos: {1}; termos só na energia cinética: {2}.",
        "Koordinaten: {0}; Bindungen: {1}; Terme allein der kinetischen Energie: {2}.",
        "Coordonnées : {0} ; liaisons : {1} ; termes dans la seule énergie cinétique : {2}.",
        "Coordenadas: {0}; ligaduras: {1}; términos solo en la energía cinética: {2}."),
    "Coordinates: {0}; constraints: {1}; terms in the equations of motion: {2}.": (
        "Coordenadas: {0}; vínculos: {1}; termos nas equações de movimento: {2}.",
        "Koordinaten: {0}; Bindungen: {1}; Terme der Bewegungsgleichungen: {2}.",
        "Coordonnées : {0} ; liaisons : {1} ; termes dans les équations du mouvement : {2}.",
        "Coordenadas: {0}; ligaduras: {1}; términos en las ecuaciones de movimiento: {2}."),
    "Coordinates: {0}; constraints: {1}; terms in the equations of motion: more than {2}.": (
        "Coordenadas: {0}; vínculos: {1}; termos nas equações de movimento: mais de {2}.",
        "Koordinaten: {0}; Bindungen: {1}; Terme der Bewegungsgleichungen: mehr als {2}.",
        "Coordonnées : {0} ; liaisons : {1} ; termes dans les équations du mouvement : plus de {2}.",
        "Coordenadas: {0}; ligaduras: {1}; términos en las ecuaciones de movimiento: más de {2}."),
    "That is too many to read. Here are the energies and the structure; --force writes everything.": (
        "É demais para ler. Aqui estão as energias e a estrutura; --force escreve tudo.",
        "Das ist zu viel zum Lesen. Hier sind die Energien und die Struktur; --force schreibt alles.",
        "C'est trop pour être lu. Voici les énergies et la structure ; --force écrit tout.",
        "Es demasiado para leer. Aquí están las energías y la estructura; --force lo escribe todo."),
    "That is too many to read. Here are the energies and the structure; --form linear gives the small motion, --force writes "
    "everything.": (
        "É demais para ler. Aqui estão as energias e a estrutura; --form linear dá os pequenos movimentos, --force escreve tudo.",
        "Das ist zu viel zum Lesen. Hier sind die Energien und die Struktur; --form linear gibt die kleinen Bewegungen, --force "
        "schreibt alles.",
        "C'est trop pour être lu. Voici les énergies et la structure ; --form linear donne les petits mouvements, --force "
        "écrit tout.",
        "Es demasiado para leer. Aquí están las energías y la estructura; --form linear da los pequeños movimientos, --force lo "
        "escribe todo."),
    "Structure": ("Estrutura", "Struktur", "Structure", "Estructura"),
    "The mass matrix couples the coordinates so:": (
        "A matriz de massa acopla as coordenadas assim:", "Die Massenmatrix koppelt die Koordinaten so:",
        "La matrice de masse couple ainsi les coordonnées :", "La matriz de masas acopla así las coordenadas:"),
    "and {0} more": ("e mais {0}", "und {0} weitere", "et {0} de plus", "y {0} más"),
    # ---- in formulas
    "for": ("para", "für", "pour", "para"),
    "otherwise": ("caso contrário", "sonst", "sinon", "en otro caso"),
}
